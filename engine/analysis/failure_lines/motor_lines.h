// Where motors and their amplifiers reach their limits: voltage, current, force and heat.
#pragma once

#include "engine/analysis/failure_lines/failure_line.h"
#include "engine/analysis/stability/stability_case.h"

namespace springdrive {

/// What the amplifier cannot give.
[[nodiscard]] std::vector<TriedLine> amplifier_lines(const DeviceDescription &device);

/// Where the servo's last stage holds e_W back before anything is reached.
[[nodiscard]] std::vector<TriedLine> held_back_lines(const StabilityCase &which);

/// How warm windings may get, and what warmth makes of a held contact.
[[nodiscard]] std::vector<TriedLine> heat_lines(const DeviceDescription &device);

} // namespace springdrive
