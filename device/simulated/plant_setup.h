// From a device's description and options to the parts that SimulatedPhantom runs.
#pragma once

#include "device/core/device_file.h"
#include "device/simulated/linkage_step.h"
#include "device/simulated/simulation_options.h"

#include <array>
#include <cstdint>

namespace springdrive::simulated {

/// @throw InputError for options that are out of range or do not go together.
void check_options(const device::DeviceDescription &description, const SimulationOptions &options);

/// Joint angles for a tip at `start_tip_m`.
/// @throw InputError where that is out of reach or, with joint limits on, beyond them.
[[nodiscard]] Vector3 start_angles(const device::DeviceDescription &description,
                                   const SimulationOptions &options, const Vector3 &start_tip_m);

/// How much of a device is simulated, ready to run.
struct PlantParts {
    PlantDynamics dynamics = PlantDynamics::electromechanical;
    PlantEffects effects;
    double longest_step_s = 0.0;
    double hand_mass_kg = 0.0; ///< none where nothing has a mass
    LinkagePlant linkage; ///< and rotors, with the effects that are on and what sits at the tip
    /// The true ones: off their data sheet by `resistance_share`, with or without ripple and
    /// inductance.
    std::array<device::MotorParameters, 3> motor;
    std::array<device::WindingTemperature, 3> temperature; ///< at the start
    std::uint32_t number = 0; ///< which they are, of those that followed
};

/// @throw InputError as `check_options` does.
[[nodiscard]] PlantParts plant_parts(const device::DeviceDescription &description,
                                     const SimulationOptions &options);

/// By how much finer an encoder is made to count as exact: so that it does not quantise for any
/// purpose here, or as much as the counts of a whole turn of every joint leave room for.
[[nodiscard]] int fine_encoder_factor(const device::DeviceDescription &description);

} // namespace springdrive::simulated
