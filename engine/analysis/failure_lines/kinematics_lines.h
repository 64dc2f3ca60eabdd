// Where inverse kinematics (18) fails: near q₂ − q₃ = ±90° and r = 0.
#pragma once

#include "device/device_file.h"
#include "engine/analysis/failure_lines/failure_line.h"

namespace springdrive {

[[nodiscard]] std::vector<TriedLine> inverse_lines(const DeviceDescription &device);

} // namespace springdrive
