// What is read from a trial: its level's name, whether its answer is right, what the method learns.
#pragma once

#include "engine/study/protocol/protocol.h"
#include "engine/study/store/study_contents.h"

#include <optional>
#include <string>

namespace springdrive::study {

/// The name of what a level is: the parameter under test with its unit, such as "turn_deg"; with
/// "_added" or "_taken_off" where levels are differences from the standard.
[[nodiscard]] std::string level_name_of(const Protocol &protocol);

/// Whether the response is the right one; nothing without a response, and where the task has no
/// right one: yes/no and adjustment.
[[nodiscard]] std::optional<bool> is_correct(const Task &task, const Trial &trial);

/// What the method learns of a stored trial.
[[nodiscard]] Outcome outcome_of(const Protocol &protocol, const Trial &trial);

} // namespace springdrive::study
