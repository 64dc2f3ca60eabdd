// Where inverse kinematics (18) fails: near q₂ − q₃ = ±90° and r = 0.
#pragma once

#include "device/core/device_file.h"
#include "engine/lab/limits/failure_lines/failure_line.h"

namespace springdrive::limits {

[[nodiscard]] std::vector<TriedLine> inverse_lines(const device::DeviceDescription &device);

} // namespace springdrive::limits
