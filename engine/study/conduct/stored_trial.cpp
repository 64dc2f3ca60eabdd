#include "engine/study/conduct/stored_trial.h"

#include <variant>

namespace springdrive::study {

namespace {

/// Names of tracks, from 1; empty where there is one only.
std::string track_name(const Method &method, int track) {
    const auto *staircases = std::get_if<Staircases>(&method);
    const bool has_several = staircases != nullptr && staircases->start_levels.size() > 1;
    return has_several ? std::to_string(track + 1) : std::string();
}

} // namespace

std::string level_name_of(const Protocol &protocol) {
    switch (protocol.variable.level) {
    case LevelMeaning::added:
        return protocol.variable.parameter + "_added";
    case LevelMeaning::taken_off:
        return protocol.variable.parameter + "_taken_off";
    case LevelMeaning::value:
        break;
    }
    return protocol.variable.parameter;
}

Trial before_it_is_run(const Protocol &protocol, const PlannedTrial &planned) {
    Trial trial;
    trial.place = planned.place;
    trial.condition = protocol.conditions[planned.condition].name;
    trial.track = track_name(protocol.method, planned.presented.track);
    trial.is_practice = planned.presented.kind == TrialKind::practice;
    trial.is_catch = planned.presented.kind == TrialKind::catch_trial;
    trial.seed = planned.key.bits;
    trial.level_name = level_name_of(protocol);
    trial.level = planned.presented.level;
    if (is_forced_choice(protocol.task.kind)) {
        trial.target = planned.presented.target + 1;
    }
    trial.repetition_of = planned.repetition_of;
    return trial;
}

bool is_of(const Protocol &protocol, const PlannedTrial &planned, const Trial &trial) {
    const Trial wanted = before_it_is_run(protocol, planned);
    return trial.place == wanted.place && trial.condition == wanted.condition &&
           trial.track == wanted.track && trial.is_practice == wanted.is_practice &&
           trial.is_catch == wanted.is_catch && trial.seed == wanted.seed &&
           trial.level_name == wanted.level_name && trial.level == wanted.level &&
           trial.target == wanted.target && trial.repetition_of == wanted.repetition_of;
}

std::optional<bool> is_correct(const Task &task, const Trial &trial) {
    const auto *chosen = std::get_if<Chosen>(&trial.response);
    if (!is_forced_choice(task.kind) || chosen == nullptr || !trial.target) {
        return std::nullopt;
    }
    return chosen->alternative == *trial.target;
}

Outcome outcome_of(const Protocol &protocol, const Trial &trial) {
    Outcome outcome;
    outcome.marked = trial.is_presented_again;
    if (const auto *answer = std::get_if<YesNo>(&trial.response)) {
        outcome.positive = answer->yes;
    } else if (const auto *adjusted = std::get_if<Adjusted>(&trial.response)) {
        outcome.setting = adjusted->level;
    } else {
        outcome.positive = is_correct(protocol.task, trial).value_or(false);
    }
    return outcome;
}

} // namespace springdrive::study
