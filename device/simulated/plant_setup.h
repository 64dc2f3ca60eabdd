// Builds the parts that SimulatedPhantom runs from a device's description and options.
#pragma once

#include "device/core/device_description.h"
#include "device/simulated/linkage_step.h"
#include "device/simulated/simulation_options.h"

#include <array>
#include <cstdint>

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
};

/// One device of a kind: its motors and current sensors, drawn at random within the tolerances of
/// the device file.
struct SampledDevice {
    std::array<SampledMotor, 3> motor;
};

/// The device of a seed. Its deviations are independent, each uniform from minus to plus its
/// tolerance, and the phase is uniform over a period of the ripple. Seed 0 is the device of the
/// file, with ideal sensors.
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
    double longest_step_s = 0.0;
    double delay_periods = 0.0;
    device::HandParameters hand; ///< massless if the dynamics are
    LinkagePlant linkage;        ///< with rotors, enabled effects and the load at the tip
    /// True parameters: R is the file's times the `resistance_share` of the options and of the
    /// sampled motor; ripple and L are zero unless they are simulated.
    std::array<device::MotorParameters, 3> motor;
    std::array<MotorSensing, 3> sensing;
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
