// Where the servo fails, or stops before it does: missed ticks, jitter, a late or lost device, a
// hung window, a change of scene and a hand that releases.
#pragma once

#include "engine/lab/limits/method_limits/method_limit.h"
#include "engine/lab/loops/stability_case.h"

namespace springdrive::limits {

/// At 1 kHz, by the servo's own loop on simulated devices.
[[nodiscard]] std::vector<LimitTrial> servo_trials(const loops::StabilityCase &which);

} // namespace springdrive::limits
