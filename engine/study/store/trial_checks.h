// What can be seen to be wrong with a row before it is stored.
#pragma once

#include "engine/study/store/study_contents.h"

#include <string>
#include <string_view>

namespace springdrive::study {

// Each is empty for a row that can be stored; one line otherwise.

[[nodiscard]] std::string what_is_wrong_with(const Participant &participant);
[[nodiscard]] std::string what_is_wrong_with(const Session &session);
/// @param records_folder  of the study
[[nodiscard]] std::string what_is_wrong_with(const Trial &trial, std::string_view records_folder);
[[nodiscard]] std::string what_is_wrong_with(const QuestionnaireAnswer &answer);
[[nodiscard]] std::string what_is_wrong_with(const Note &note);

} // namespace springdrive::study
