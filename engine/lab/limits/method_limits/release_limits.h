// What happens when a pressing hand releases the device.
#pragma once

#include "engine/lab/limits/method_limits/method_limit.h"
#include "engine/lab/loops/stability_case.h"

namespace springdrive::limits {

/// The contact then expels the tip. The force from which on that trips the limit of tip speed: with
/// the limit of the device file, and with a lower one.
/// @param which  its hands are ignored: a firm one presses
[[nodiscard]] std::vector<LimitTrial> release_trials(const loops::StabilityCase &which);

} // namespace springdrive::limits
