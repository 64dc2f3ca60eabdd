// Builds the parts that SimulatedPhantom runs from a device's description and options.
#pragma once

#include "device/core/device_description.h"
#include "device/simulated/linkage_step.h"
#include "device/simulated/simulation_options.h"

#include <array>
#include <cstdint>

namespace springdrive::simulated {

/// A sensor's reading of a current i is gain · i + offset.
struct SensorError {
    double gain = 1.0;
    double offset_A = 0.0;
};

/// What measures one motor's current.
struct MotorSensing {
    SensorError converter; ///< for the servo
    SensorError amplifier; ///< for R̂ i of (6)
    double resolution_A = 0.0;
    double noise_A = 0.0; ///< r.m.s., of the converter
};

/// One motor's deviations from the device file.
struct DrawnMotor {
    double resistance_share = 1.0;
    double torque_constant_share = 1.0;
    double commutator_phase_rad = 0.0;
    MotorSensing sensing;
};

/// One device of a kind: its motors and current sensors, drawn at random within the tolerances of
/// the device file.
struct SampledDevice {
    std::array<DrawnMotor, 3> motor;
};

/// Each deviation is uniform within its tolerance, either way, and independent of the others; the
/// phase is uniform over a ripple. Seed 0 is the device of the file, with ideal sensors.
[[nodiscard]] SampledDevice sampled_device(const device::DeviceDescription &description,
                                           std::uint64_t seed);

/// @throw InputError for options that are out of range or incompatible.
void check_options(const device::DeviceDescription &description, const SimulationOptions &options);

/// Joint angles with the tip at `start_tip_m`.
/// @throw InputError if it is out of reach or, with joint limits on, beyond them.
[[nodiscard]] Vector3 start_angles(const device::DeviceDescription &description,
                                   const SimulationOptions &options, const Vector3 &start_tip_m);

/// The parts of a simulated device, ready to run.
struct PlantParts {
    PlantDynamics dynamics = PlantDynamics::electromechanical;
    PlantEffects effects;
    double longest_step_s = 0.0;
    double delay_periods = 0.0;
    device::HandParameters hand; ///< without mass if the dynamics have none
    LinkagePlant linkage;        ///< with rotors, enabled effects and the load at the tip
    /// True parameters: R differs from the data sheet by `resistance_share`, and as drawn; ripple
    /// and inductance as enabled.
    std::array<device::MotorParameters, 3> motor;
    std::array<MotorSensing, 3> sensing;
    std::array<device::WindingTemperature, 3> temperature; ///< initial
    std::uint32_t number = 0; ///< sequence number of the published parts
};

/// What a simulated device reports of itself: with its encoders, and with tolerances of zero where
/// it is exactly as its file says.
[[nodiscard]] device::DeviceDescription
simulated_description(const device::DeviceDescription &description,
                      const SimulationOptions &options);

/// @throw InputError as `check_options` does.
[[nodiscard]] PlantParts plant_parts(const device::DeviceDescription &description,
                                     const SimulationOptions &options);

/// The factor by which an encoder's resolution is increased so that its quantisation is negligible,
/// limited so that the counts of a full turn of every joint fit.
[[nodiscard]] int fine_encoder_factor(const device::DeviceDescription &description);

} // namespace springdrive::simulated
