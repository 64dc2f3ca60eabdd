// Between a trial as it is planned and as it is stored.
#pragma once

#include "engine/study/conduct/sequence.h"

#include <string>

namespace springdrive::study {

/// The name of what a level is: the parameter under test with its unit, such as "turn_deg"; with
/// "_added" or "_taken_off" where levels are differences from the standard.
[[nodiscard]] std::string level_name_of(const Protocol &protocol);

/// What is known of a trial before it is run. Participant and session are left empty.
[[nodiscard]] Trial before_it_is_run(const Protocol &protocol, const PlannedTrial &planned);

/// Whether a stored trial is the planned one: place, condition, track, kind, level, target, key.
[[nodiscard]] bool is_of(const Protocol &protocol, const PlannedTrial &planned, const Trial &trial);

/// Whether the response is the right one; nothing without a response, and where the task has no
/// right one: yes/no and adjustment.
[[nodiscard]] std::optional<bool> is_correct(const Task &task, const Trial &trial);

/// What the method learns of a stored trial.
[[nodiscard]] Outcome outcome_of(const Protocol &protocol, const Trial &trial);

} // namespace springdrive::study
