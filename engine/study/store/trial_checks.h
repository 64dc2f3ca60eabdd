// What can be seen to be wrong with a row before it is stored. What leads to files is seen again
// when it is read: the file may come from anybody.
#pragma once

#include "engine/study/store/study_contents.h"

#include <string>
#include <string_view>

namespace springdrive::study {

// Each is empty for a row that can be stored; one line otherwise.

/// The folder of servo records: NAME.records, beside the study.
[[nodiscard]] std::string validate_records_folder(std::string_view name);
[[nodiscard]] std::string validate(const Participant &participant);
[[nodiscard]] std::string validate(const Session &session);
/// @param records_folder  of the study
[[nodiscard]] std::string validate(const Trial &trial, std::string_view records_folder);
/// The trial's record, if it has one, which must be in its participant's folder.
[[nodiscard]] std::string validate_record(const Trial &trial, std::string_view records_folder);
[[nodiscard]] std::string validate(const QuestionnaireAnswer &answer);
[[nodiscard]] std::string validate(const Note &note);

} // namespace springdrive::study
