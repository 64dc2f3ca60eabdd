// Where motors and their amplifiers reach their limits: voltage, current, force and heat.
#pragma once

#include "engine/lab/limits/failure_lines/failure_line.h"
#include "engine/lab/loops/stability_case.h"

namespace springdrive::limits {

inline constexpr const char *kMotorMethod = "motor";

/// Limits of the amplifier.
[[nodiscard]] std::vector<TriedLine> amplifier_lines(const device::DeviceDescription &device);

/// Where the servo's last stage limits e_W before the motor's or the device's limits are reached.
[[nodiscard]] std::vector<TriedLine> held_back_lines(const loops::StabilityCase &which);

/// Limits of winding temperature, and the effect of warming on a held contact.
[[nodiscard]] std::vector<TriedLine> heat_lines(const device::DeviceDescription &device);

} // namespace springdrive::limits
