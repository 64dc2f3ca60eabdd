// Where inverse kinematics (18) fails: near q₂ − q₃ = ±90° and r = 0.
#pragma once

#include "device/core/device_description.h"
#include "engine/lab/limits/method_limits/method_limit.h"

namespace springdrive::limits {

[[nodiscard]] std::vector<LimitTrial> inverse_trials(const device::DeviceDescription &device);

} // namespace springdrive::limits
