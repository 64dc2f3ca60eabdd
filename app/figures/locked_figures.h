// Shared by figures 5 and 6: the locked device, imperfect and ideal.
#pragma once

#include "app/figures/figure.h"
#include "engine/lab/limits/locked_device.h"

#include <string>

namespace springdrive::app {

/// As on a real device, pressed as deep as its limits permit with this map.
[[nodiscard]] limits::LockedDeviceOptions with_effects(const FigureSetting &setting,
                                                       control::MotionMap map);

/// As in the equations, pressed so little that their linearity in Δx holds.
[[nodiscard]] limits::LockedDeviceOptions without_effects(const FigureSetting &setting,
                                                          control::MotionMap map);

/// Which effects were on: "encoders, friction, …".
[[nodiscard]] std::string effects_text(const limits::LockedDeviceOptions &options);

/// "1.2 mm"
[[nodiscard]] std::string penetration_text(const limits::LockedDeviceOptions &options);

} // namespace springdrive::app
