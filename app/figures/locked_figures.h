// Shared by figures 3, 5 and 6: the locked device, imperfect and ideal.
#pragma once

#include "app/figures/figure.h"
#include "engine/lab/limits/locked_device.h"

#include <cstdint>
#include <string>

namespace springdrive::app {

/// What is pressed against a surface.
enum class Locked : std::uint8_t {
    unobserved, ///< a drawn device with everything on; R̂ is set by the device file's R
    observed,   ///< the same, where R̂ follows the resistances that the servo observes
    ideal,      ///< as in the equations, pressed so little that their linearity in Δx holds
};

/// Pressed as deep as the device's limits permit with this map.
[[nodiscard]] limits::LockedDeviceOptions locked_options(const FigureSetting &setting,
                                                         control::MotionMap map, Locked how);

/// The depth that the device's limits permit with both maps.
[[nodiscard]] double common_penetration_m(const FigureSetting &setting);

/// What is measured, with the effects that are on.
[[nodiscard]] std::string conditions_text(const FigureSetting &setting);

/// "1.2 mm"
[[nodiscard]] std::string penetration_text(double penetration_m);

} // namespace springdrive::app
