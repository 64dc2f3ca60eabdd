// From a device's description and options to the parts that SimulatedPhantom runs.
#pragma once

#include "device/device_file.h"
#include "device/simulated/linkage_step.h"
#include "device/simulated/simulation_options.h"

#include <array>

namespace springdrive {

/// @throw InputError for options that are out of range or do not go together.
void check_options(const DeviceDescription &description, const SimulationOptions &options);

/// Joint angles for a tip at `start_tip_m`.
/// @throw InputError where that is out of reach or, with joint limits on, beyond them.
[[nodiscard]] Vector3 start_angles(const DeviceDescription &description,
                                   const SimulationOptions &options, const Vector3 &start_tip_m);

/// Linkage and rotors, with the effects that are on and what sits rigidly at the tip.
[[nodiscard]] LinkagePlant linkage_plant(const DeviceDescription &description,
                                         const SimulationOptions &options);

/// The motors as they truly are: off their data sheet by `resistance_share`, with or without
/// ripple and inductance.
[[nodiscard]] std::array<MotorParameters, 3> true_motors(const DeviceDescription &description,
                                                         const SimulationOptions &options);

/// Winding and housing at the start.
[[nodiscard]] WindingTemperature temperature(const MotorParameters &motor,
                                             const SimulationOptions &options);

/// By how much finer an encoder is made to count as exact: so that it does not quantise for any
/// purpose here, or as much as the counts of a whole turn of every joint leave room for.
[[nodiscard]] int fine_encoder_factor(const DeviceDescription &description);

} // namespace springdrive
