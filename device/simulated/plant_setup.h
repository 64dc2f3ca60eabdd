// Builds the parts that SimulatedPhantom runs from a device's description and options.
#pragma once

#include "device/core/device_description.h"
#include "device/simulated/linkage_step.h"
#include "device/simulated/simulation_options.h"

#include <array>
#include <cstdint>
#include <optional>

namespace springdrive::simulated {

/// A current sensor's errors: of a current i it reads gain · i + offset.
struct SensorError {
    double gain = 1.0;
    double offset_A = 0.0;
};

/// The sensors of one motor's current.
struct MotorSensing {
    SensorError converter;     ///< its reading goes to the servo
    SensorError amplifier;     ///< its reading is fed back as R̂ i, (6)
    double resolution_A = 0.0; ///< step of the converter
    double noise_A = 0.0;      ///< r.m.s. noise of the converter
};

/// One motor's deviations from the device file.
struct SampledMotor {
    double resistance_share = 1.0;      ///< R relative to the file's
    double torque_constant_share = 1.0; ///< k_T relative to the file's
    double commutator_phase_rad = 0.0;
    MotorSensing sensing;
    double winding_housing_share = 1.0;    ///< R_wh relative to the file's
    double brush_voltage_V = 0.0;          ///< V_b of brushes and bridge
    double brush_current_A = 0.01;         ///< i_b after a rest
    double carried_brush_current_A = 0.01; ///< i_b after large currents
    double brush_film_s = 10.0;            ///< time constant of i_b
    // The file's ripple of R is the sum of its two harmonics' amplitudes.
    int ripples_per_segment = 1;        ///< 2: as brushes on an odd number of segments commutate
    double second_harmonic_ratio = 0.0; ///< of the ripple, relative to its fundamental
    double second_harmonic_phase_rad = 0.0;
    double torque_ripple = 0.0; ///< of k_T(θ): amplitude as a share; as many periods as R's ripple
    double torque_ripple_phase_rad = 0.0;
};

/// One device of a kind: its motors, current sensors and structure, drawn at random within the
/// tolerances of the device file.
struct SampledDevice {
    std::array<SampledMotor, 3> motor;
    double cable_share = 0.5; ///< of the structure's compliance: the file's, if it tells it
};

/// The device of a seed. Seed 0 is the device of the file, with ideal brushes and sensors. Else its
/// deviations are independent, uniform from minus to plus their tolerances, phases over a period,
/// and in particular:
/// - V_b from 1/50 of the file's greatest to that, i_b from 10 to 200 mA, the film's time constant
///   from 2 to 60 s, R_wh from half to twice the file's: uniform in their logarithms
/// - the second harmonic of R's ripple from 0 to 1/4 of the first; the ripple of k_T from half of
///   the file's greatest to that
/// - of an odd number of segments each second device has two ripples per segment
/// - the cables' share from 0 to 1, where the file does not tell it
[[nodiscard]] SampledDevice sampled_device(const device::DeviceDescription &description,
                                           std::uint64_t seed);

/// Rejects options that no simulated device can have.
/// @throw InputError for options that are out of range or incompatible
void check_options(const device::DeviceDescription &description, const SimulationOptions &options);

/// The joint angles with the tip at `start_tip_m`.
/// @throw InputError if it is out of reach or, with joint limits on, beyond them
[[nodiscard]] Vector3 start_angles_rad(const device::DeviceDescription &description,
                                       const SimulationOptions &options,
                                       const Vector3 &start_tip_m);

/// The parts of a simulated device, ready to run.
struct PlantParts {
    PlantDynamics dynamics = PlantDynamics::electromechanical;
    PlantEffects effects;
    double longest_step_s = 0.0; ///< with cables, short enough for what swings on them
    double delay_periods = 0.0;
    device::HandParameters hand; ///< massless if the dynamics are
    LinkagePlant linkage;        ///< with what is rigidly connected to it: rotors, load at the tip
    std::optional<device::StructuralCompliance> tip_structure; ///< between linkage and tip
    std::optional<std::array<device::CableCompliance, 3>> cables;
    /// True parameters: R is the file's times the `resistance_share` of the options and of the
    /// sampled motor; ripple and L are zero unless they are simulated.
    std::array<device::MotorParameters, 3> motor;
    SampledDevice own; ///< its deviations, as far as they are simulated
    std::array<device::WindingTemperature, 3> temperature; ///< winding and housing at the start
    std::uint32_t number = 0;                              ///< counts the parts that were published
};

/// The description that a simulated device reports: with the resolution of its encoders, and with
/// tolerances of zero where it is exactly as its file says.
[[nodiscard]] device::DeviceDescription
simulated_description(const device::DeviceDescription &description,
                      const SimulationOptions &options);

/// The parts of a device with these options.
/// @throw InputError as `check_options` does
[[nodiscard]] PlantParts plant_parts(const device::DeviceDescription &description,
                                     const SimulationOptions &options);

/// The factor by which an encoder's resolution is increased so that its quantisation is negligible,
/// limited so that the counts of a full turn of every joint fit.
[[nodiscard]] int fine_encoder_factor(const device::DeviceDescription &description);

} // namespace springdrive::simulated
