// Where motors and their amplifiers reach their limits: voltage, current, force and heat.
#pragma once

#include "engine/lab/limits/failure_lines/failure_line.h"
#include "engine/lab/loops/stability_case.h"

namespace springdrive::limits {

inline constexpr const char *kMotorMethod = "motor";

/// What the amplifier cannot give.
[[nodiscard]] std::vector<TriedLine> amplifier_lines(const device::DeviceDescription &device);

/// Where the servo's last stage holds e_W back before anything is reached.
[[nodiscard]] std::vector<TriedLine> held_back_lines(const loops::StabilityCase &which);

/// How warm windings may get, and what warmth makes of a held contact.
[[nodiscard]] std::vector<TriedLine> heat_lines(const device::DeviceDescription &device);

} // namespace springdrive::limits
