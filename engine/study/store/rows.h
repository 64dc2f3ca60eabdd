// Rows of a study file, and the list of their fields.
#pragma once

#include "engine/study/store/database.h"
#include "engine/study/store/study_contents.h"

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace springdrive::study {

// The fields of each row, listed once: for storing, reading and the row's SHA-256.
//
// for_each_field(row, f) calls f(columns, value): some values take more than one column.
// for_each_list(row, f) calls f(table, values) for the child rows.

struct StudyRow {
    StudyFacts facts;
    bool is_to_compact = false; ///< a deletion is complete but for the rebuilding of the file
};

struct ParticipantRow {
    Participant participant;
    bool is_being_removed = false; ///< removed already as far as readers can see
};

/// A stimulus value with its presentation, from 1.
struct StimulusRow {
    int presentation = 1;
    StimulusValue value;
};

template <typename Row, typename Value>
concept RowOf = std::same_as<std::remove_const_t<Row>, Value>;

template <RowOf<StudyRow> Row, typename Field> void for_each_field(Row &row, Field &&field) {
    field("title", row.facts.title);
    field("protocol", row.facts.protocol);
    field("protocol_sha256", row.facts.protocol_sha256);
    field("created_utc", row.facts.created);
    field("software", row.facts.software);
    field("records_folder", row.facts.records_folder);
    field("removed_participants", row.facts.removed_participants);
    field("is_to_compact", row.is_to_compact);
}

template <RowOf<ParticipantRow> Row, typename Field> void for_each_field(Row &row, Field &&field) {
    field("code", row.participant.code);
    field("number", row.participant.number);
    field("added_utc", row.participant.added);
    field("is_being_removed", row.is_being_removed);
}

template <RowOf<Session> Row, typename Field> void for_each_field(Row &row, Field &&field) {
    field("participant", row.participant);
    field("started_utc", row.started);
    field("ended_utc", row.ended);
    field("ending", row.ending);
    field("device_kind", row.device);
    field("device_name", row.device_name);
    field("device_serial", row.device_serial);
    field("software", row.software);
    field("host", row.host);
}
template <RowOf<Session> Row, typename List> void for_each_list(Row &row, List &&list) {
    list("session_fact", row.facts);
}

template <RowOf<Setting> Row, typename Field> void for_each_field(Row &row, Field &&field) {
    field("name", row.name);
    field("value", row.value);
}

template <RowOf<Trial> Row, typename Field> void for_each_field(Row &row, Field &&field) {
    field("participant", row.participant);
    field("block, position, attempt", row.place);
    field("session", row.session);
    field("condition", row.condition);
    field("track", row.track);
    field("is_practice", row.is_practice);
    field("is_catch", row.is_catch);
    field("is_presented_again", row.is_presented_again);
    field("seed", row.seed);
    field("level_name", row.level_name);
    field("level", row.level);
    field("target", row.target);
    field("response, chosen, adjusted", row.response);
    field("is_correct", row.is_correct);
    field("response_time_s", row.response_time_s);
    field("at_utc", row.at);
    field("software", row.software);
    field("missed_deadlines", row.missed_deadlines);
    field("record_path, record_sha256", row.record);
    field("repeats_block, repeats_position, repeats_attempt", row.repetition_of);
}
template <RowOf<Trial> Row, typename List> void for_each_list(Row &row, List &&list) {
    list("presentation", row.presentations);
    std::vector<StimulusRow> values;
    if constexpr (std::is_const_v<Row>) {
        for (std::size_t i = 0; i < row.presentations.size(); ++i) {
            for (const StimulusValue &value : row.presentations[i].values) {
                values.push_back({static_cast<int>(i) + 1, value});
            }
        }
        list("stimulus_value", values);
    } else { // loaded; a value of no presentation is lost, which the row's SHA-256 tells
        list("stimulus_value", values);
        for (StimulusRow &value : values) {
            const auto number = static_cast<std::size_t>(value.presentation);
            if (number >= 1 && number <= row.presentations.size()) {
                row.presentations[number - 1].values.push_back(std::move(value.value));
            }
        }
    }
    list("tuning_value", row.tuning);
    list("winding", row.windings_degC);
    list("safety_event", row.safety_events);
    list("mark", row.marks);
}

template <RowOf<Presentation> Row, typename Field> void for_each_field(Row &row, Field &&field) {
    field("start_s", row.start_s);
    field("end_s", row.end_s);
}

template <RowOf<StimulusRow> Row, typename Field> void for_each_field(Row &row, Field &&field) {
    field("presentation", row.presentation);
    field("name", row.value.name);
    field("intended", row.value.intended);
    field("delivered", row.value.delivered);
}

/// A temperature.
template <RowOf<std::optional<double>> Row, typename Field>
void for_each_field(Row &row, Field &&field) {
    field("temperature_degC", row);
}

template <RowOf<SafetyEvent> Row, typename Field> void for_each_field(Row &row, Field &&field) {
    field("time_s", row.time_s);
    field("text", row.text);
}

/// The reason of a mark.
template <RowOf<std::string> Row, typename Field> void for_each_field(Row &row, Field &&field) {
    field("reason", row);
}

template <RowOf<QuestionnaireAnswer> Row, typename Field>
void for_each_field(Row &row, Field &&field) {
    field("participant", row.participant);
    field("session", row.session);
    field("item", row.item);
    field("question", row.question);
    field("answer", row.answer);
    field("at_utc", row.at);
}

template <RowOf<Note> Row, typename Field> void for_each_field(Row &row, Field &&field) {
    field("participant", row.participant);
    field("session", row.session);
    field("at_utc", row.at);
    field("kind", row.kind);
    field("text", row.text);
}

/// Rows without child rows.
template <typename Row, typename List> void for_each_list(Row & /*row*/, List && /*list*/) {}

// Rows of a study file with their child rows: of types StudyRow, ParticipantRow, Session, Trial,
// QuestionnaireAnswer and Note. They are checked by their SHA-256 as they are read.
//
// Each call is part of a transaction of its caller.

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
