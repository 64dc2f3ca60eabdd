#include "engine/study/conduct/stored_trial.h"

#include <variant>

namespace springdrive::study {

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
