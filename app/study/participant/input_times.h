// When a participant did something: noted by the steady clock, stored by the servo's.
#pragma once

#include "app/study/participant/participant_input.h"
#include "engine/session/servo_run.h"

#include <vector>

namespace springdrive::app::study_screen {

/// Of std::chrono::steady_clock, since its epoch.
[[nodiscard]] double steady_clock_s();

/// Of the servo's clock, before the steady one.
[[nodiscard]] double servo_ahead_s(const session::ServoRun &servo);

/// Sets the inputs' `clock_s` to the servo's clock; in lockstep, which has frames only, to its time
/// now.
void tell_by_servo(std::vector<ParticipantInput> &inputs, const session::ServoRun &servo);

} // namespace springdrive::app::study_screen
