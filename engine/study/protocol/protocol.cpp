#include "engine/study/protocol/protocol.h"

#include "engine/control/coupling.h"
#include "engine/study/methods/wrong_value.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <variant>

namespace springdrive::study {

namespace {

/// From the lowest to the highest in equal steps.
std::vector<double> ladder(Scale scale, double lowest, double highest, int steps) {
    const double from = on_scale(scale, lowest);
    const double to = on_scale(scale, highest);
    std::vector<double> levels{lowest};
    for (int i = 1; i < steps; ++i) {
        levels.push_back(level_from(scale, from + (to - from) * i / steps));
    }
    levels.push_back(highest);
    return levels;
}

std::vector<double> levels_of(const Method &method, int steps) {
    return std::visit(
        [steps](const auto &one) {
            using Kind = std::decay_t<decltype(one)>;
            if constexpr (std::is_same_v<Kind, Staircases> || std::is_same_v<Kind, Adjustment>) {
                return ladder(one.scale, one.minimum_level, one.maximum_level, steps);
            } else {
                return one.levels;
            }
        },
        method);
}

} // namespace

const ParameterFacts &variable_of(const Protocol &protocol) {
    return *condition_parameter_named(protocol.variable.parameter);
}

double value_at(const Protocol &protocol, double level) {
    switch (protocol.variable.level) {
    case LevelMeaning::added:
        return protocol.variable.standard + level;
    case LevelMeaning::taken_off:
        return protocol.variable.standard - level;
    case LevelMeaning::value:
        break;
    }
    return level;
}

Condition comparison(const Protocol &protocol, std::size_t condition, double level, int target) {
    Condition one = protocol.conditions[condition];
    variable_of(protocol).set(one, value_at(protocol, level));
    if (protocol.task.kind == TaskKind::forced_choice_by_place) {
        one.turn_axis_deg =
            std::remainder(one.turn_axis_deg + 360.0 * target / protocol.task.alternatives, 360.0);
    }
    return one;
}

std::optional<std::size_t> standard_condition_of(const Protocol &protocol) {
    const auto found = std::ranges::find(protocol.conditions, protocol.variable.standard_condition,
                                         &Condition::name);
    if (protocol.variable.standard_condition.empty() || found == protocol.conditions.end()) {
        return std::nullopt;
    }
    return static_cast<std::size_t>(found - protocol.conditions.begin());
}

Condition standard(const Protocol &protocol, std::size_t condition) {
    Condition one = protocol.conditions[standard_condition_of(protocol).value_or(condition)];
    variable_of(protocol).set(one, protocol.variable.standard);
    return one;
}

std::optional<control::Tuning> free_space_tuning(const Protocol &protocol,
                                                 const Condition &condition) {
    control::Tuning tuning = condition.tuning;
    if (protocol.free_space_is_stimulus || !protocol.free_space) {
        return tuning;
    }
    const Condition &first = protocol.conditions.front();
    const double lag_s = control::loop_lag_s(protocol.free_space->lambda_rad_per_s,
                                             1.0 / first.servo_hz, first.delay_periods);
    const std::optional<double> lambda_rad_per_s =
        control::lambda_of_lag_rad_per_s(lag_s, 1.0 / condition.servo_hz, condition.delay_periods);
    if (!lambda_rad_per_s) {
        return std::nullopt;
    }
    tuning.dR_Ohm = protocol.free_space->dR_Ohm;
    tuning.lambda_rad_per_s = *lambda_rad_per_s;
    return tuning;
}

Block block_of(const Protocol &protocol, std::size_t block, bool is_first) {
    return {protocol.task,
            std::vector<Method>(protocol.blocks[block].conditions.size(), protocol.method),
            is_first ? protocol.practice : Practice{}, protocol.catch_trials,
            protocol.marking.most_marked};
}

std::vector<double> presentable_levels(const Protocol &protocol, int steps) {
    std::vector<double> levels = levels_of(protocol.method, steps);
    const auto add = [&levels](const std::vector<double> &more) {
        levels.insert(levels.end(), more.begin(), more.end());
    };
    if (const auto *staircases = std::get_if<Staircases>(&protocol.method)) {
        add(staircases->start_levels);
    }
    if (protocol.practice.most_trials > 0) {
        add(protocol.practice.levels);
    }
    if (protocol.catch_trials.one_in > 0) {
        add(protocol.catch_trials.levels);
    }
    std::ranges::sort(levels);
    levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
    return levels;
}

int presentations_per_trial(const Protocol &protocol) {
    switch (protocol.task.kind) {
    case TaskKind::forced_choice_by_interval:
        return protocol.task.alternatives;
    case TaskKind::yes_no:
    case TaskKind::adjustment:
        return protocol.variable.shows_standard ? 2 : 1;
    case TaskKind::forced_choice_by_place:
        break;
    }
    return 1;
}

} // namespace springdrive::study
