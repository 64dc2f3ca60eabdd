// Rows of a study file with their child rows: of types StudyRow, ParticipantRow, Session, Trial,
// QuestionnaireAnswer and Note. They are checked by their SHA-256 as they are read.
//
// Each call is part of a transaction of its caller.
#pragma once

#include "engine/study/store/database.h"
#include "engine/study/store/fields.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::study {

/// A row with its number in its table.
template <typename Row> struct Numbered {
    std::int64_t id = 0;
    Row row{};
};

/// The id that it was given: one more than the highest.
template <typename Row> std::int64_t insert(const Database &database, const Row &row);

template <typename Row> void update(const Database &database, const Numbered<Row> &row);

/// In the order of their ids, which is that of their insertion.
/// @param id  only this one
template <typename Row>
[[nodiscard]] std::vector<Numbered<Row>> rows(const Database &database,
                                              std::optional<std::int64_t> id = std::nullopt);

/// The SHA-256 that is stored with it.
template <typename Row> [[nodiscard]] std::string digest_of(std::int64_t id, const Row &row);

/// @throw InputError as damage if there is none, or its folder of records cannot be one
[[nodiscard]] Numbered<StudyRow> study_row(const Database &database);

/// Nothing if there is none of that code, or it is being removed.
[[nodiscard]] std::optional<Numbered<ParticipantRow>> participant_row(const Database &database,
                                                                      const std::string &code);
[[nodiscard]] std::optional<Numbered<Trial>>
trial_row(const Database &database, const std::string &participant, const TrialPlace &place);

/// Nothing if the session has no answer to that item.
[[nodiscard]] std::optional<QuestionnaireAnswer>
answer_row(const Database &database, SessionId session, const std::string &item);

[[nodiscard]] bool has_repetition(const Database &database, const std::string &participant,
                                  const TrialPlace &place);

/// Everything but what belongs to a participant who is being removed.
/// @throw InputError as damage for a row that has changed, and for what would lead to files outside
///        of the study's own
[[nodiscard]] StudyContents read_contents(const Database &database);

} // namespace springdrive::study
