// What figures 5 and 6 share: the device in its vice, imperfect and ideal.
#pragma once

#include "app/figures/figure.h"
#include "engine/lab/limits/locked_device.h"

#include <string>

namespace springdrive::app {

/// As on a real device, pressed as far as its limits let this map be without harm.
[[nodiscard]] limits::LockedDeviceOptions with_effects(const FigureSetting &setting,
                                                       control::MotionMap map);

/// As the equations have it, pressed so little that their linearity in Δx holds.
[[nodiscard]] limits::LockedDeviceOptions without_effects(const FigureSetting &setting,
                                                          control::MotionMap map);

/// Which effects were on: "encoders, friction, …".
[[nodiscard]] std::string effects_text(const limits::LockedDeviceOptions &options);

/// "1.2 mm"
[[nodiscard]] std::string penetration_text(const limits::LockedDeviceOptions &options);

} // namespace springdrive::app
