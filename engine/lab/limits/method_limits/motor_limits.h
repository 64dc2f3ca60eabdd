// Where motors and their amplifiers reach their limits: voltage, current, force and heat.
#pragma once

#include "engine/lab/limits/method_limits/method_limit.h"
#include "engine/lab/loops/stability_case.h"

namespace springdrive::limits {

inline constexpr const char *kMotorMethod = "motor";

/// Limits of the amplifier.
[[nodiscard]] std::vector<LimitTrial> amplifier_trials(const device::DeviceDescription &device);

/// Where the servo's last stage limits e_W before the motor's or the device's limits are reached.
[[nodiscard]] std::vector<LimitTrial> limiter_trials(const loops::StabilityCase &which);

/// Limits of winding temperature, and the effect of warming on a held contact.
[[nodiscard]] std::vector<LimitTrial> heat_trials(const device::DeviceDescription &device);

} // namespace springdrive::limits
