// The fields of each row, listed once: for storing, reading and the row's SHA-256.
//
// for_each_field(row, f) calls f(columns, value): some values take more than one column.
// for_each_list(row, f) calls f(table, values) for the child rows.
#pragma once

#include "engine/study/store/study_contents.h"

#include <concepts>
#include <type_traits>

namespace springdrive::study {

struct StudyRow {
    StudyFacts facts;
    bool is_to_compact = false; ///< a deletion is complete but for the rebuilding of the file
};

struct ParticipantRow {
    Participant participant;
    bool is_being_removed = false; ///< removed already as far as readers can see
};

/// A stimulus value, flat.
struct StimulusRow {
    int presentation = 1;
    StimulusValue value;
};

/// A trial with all its child rows.
struct TrialRow {
    Trial trial;
    std::vector<StimulusRow> stimulus_values; ///< those of `trial.presentations`

    TrialRow() = default;
    explicit TrialRow(Trial of);
    /// Back into the trial's presentations; false if there is no such presentation.
    [[nodiscard]] bool sort_in_stimulus_values();
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

template <RowOf<TrialRow> Row, typename Field> void for_each_field(Row &row, Field &&field) {
    auto &trial = row.trial;
    field("participant", trial.participant);
    field("block, position, attempt", trial.place);
    field("session", trial.session);
    field("condition", trial.condition);
    field("track", trial.track);
    field("is_practice", trial.is_practice);
    field("is_catch", trial.is_catch);
    field("is_presented_again", trial.is_presented_again);
    field("seed", trial.seed);
    field("level_name", trial.level_name);
    field("level", trial.level);
    field("target", trial.target);
    field("response, chosen, adjusted", trial.response);
    field("is_correct", trial.is_correct);
    field("response_time_s", trial.response_time_s);
    field("at_utc", trial.at);
    field("software", trial.software);
    field("missed_deadlines", trial.missed_deadlines);
    field("record_path, record_sha256", trial.record);
    field("repeats_block, repeats_position, repeats_attempt", trial.repetition_of);
}
template <RowOf<TrialRow> Row, typename List> void for_each_list(Row &row, List &&list) {
    list("presentation", row.trial.presentations);
    list("stimulus_value", row.stimulus_values);
    list("tuning_value", row.trial.tuning);
    list("winding", row.trial.windings_degC);
    list("safety_event", row.trial.safety_events);
    list("mark", row.trial.marks);
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

} // namespace springdrive::study
