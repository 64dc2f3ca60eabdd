// What becomes of a device whose hand lets go while it presses.
#pragma once

#include "engine/lab/limits/failure_lines/failure_line.h"
#include "engine/lab/loops/stability_case.h"

namespace springdrive::limits {

/// The contact then throws the tip out. From which force on that trips the limit of tip speed: as
/// the device file has it, and as somebody lowered it.
/// @param which  its hands are not looked at: a firm one presses
[[nodiscard]] std::vector<TriedLine> letting_go_lines(const loops::StabilityCase &which);

} // namespace springdrive::limits
