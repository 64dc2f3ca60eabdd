// Answers to a protocol's questions as tables: a row an answer, and a row a session.
#pragma once

#include "base/table.h"
#include "engine/study/protocol/questionnaire.h"
#include "engine/study/store/study_contents.h"

#include <string>
#include <vector>

namespace springdrive::study {

/// A row an answer, in the order in which they were stored: `participant`,
/// `participant_number`, `session`, `device_kind`, `when`, `item`, `kind`, `question`, `answer` and
/// `at_utc`. A question that was left out has no row; `when` and `kind` are empty for an item that
/// is not among `items`.
/// @param items    of the study's protocol
/// @param devices  only answers of sessions on these
[[nodiscard]] Table answer_table(const StudyContents &contents,
                                 const std::vector<QuestionnaireItem> &items,
                                 const std::vector<DeviceKind> &devices);

/// The session's answers by item, in the order of `items`; empty where there is none.
[[nodiscard]] std::vector<std::string> answers_of(const StudyContents &contents,
                                                  const std::vector<QuestionnaireItem> &items,
                                                  SessionId session);

/// Answers of sessions on that kind of device.
[[nodiscard]] std::vector<QuestionnaireAnswer> answers_on(const StudyContents &contents,
                                                          DeviceKind device);

} // namespace springdrive::study
