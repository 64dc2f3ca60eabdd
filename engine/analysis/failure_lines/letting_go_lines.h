// What becomes of a device whose hand lets go while it presses.
#pragma once

#include "engine/analysis/failure_lines/failure_line.h"
#include "engine/analysis/stability/stability_case.h"

namespace springdrive {

/// The contact then throws the tip out. From which force on that trips the limit of tip speed: as
/// the device file has it, and as somebody lowered it.
/// @param which  its hands are not looked at: a firm one presses
[[nodiscard]] std::vector<TriedLine> letting_go_lines(const StabilityCase &which);

} // namespace springdrive
