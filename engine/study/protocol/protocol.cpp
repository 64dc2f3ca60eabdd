#include "engine/study/protocol/protocol.h"

#include "base/assertions.h"
#include "base/degrees.h"
#include "engine/control/coupling.h"
#include "engine/servo/servo.h"
#include "engine/study/methods/psychometric_function.h"
#include "engine/study/protocol/session_plan.h"

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <type_traits>
#include <variant>

namespace springdrive::study {

namespace {

static_assert(kConditionParameters[0].range.minimum == servo::kMinRate_hz &&
              kConditionParameters[0].range.maximum == servo::kMaxRate_hz);

std::vector<ParameterFacts> all_parameters() {
    std::vector<ParameterFacts> all;
    for (const control::Parameter &gain : control::kParameters) {
        all.push_back({gain.name, gain.unit, gain.minimum, gain.maximum, gain.default_value(),
                       gain.help, gain.value, nullptr});
    }
    for (const Field<Condition> &one : kConditionParameters) {
        all.push_back({one.name, one.unit, one.range.minimum, one.range.maximum,
                       one.number(Condition{}), one.help, nullptr,
                       std::get<double Condition::*>(one.member)});
    }
    return all;
}

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

/// Parameters that belong to one form of stimulus.
bool acts_in(StimulusForm form, std::string_view parameter) {
    switch (form) {
    case StimulusForm::press:
        return parameter != "speed_m_per_s" && parameter != "pulse_N" && parameter != "pulse_hz";
    case StimulusForm::blow:
        return parameter != "press_N" && parameter != "pulse_N" && parameter != "pulse_hz";
    case StimulusForm::pulse:
        return parameter != "speed_m_per_s";
    case StimulusForm::stroke:
        break;
    }
    return parameter == "dR_Ohm" || parameter == "lambda_rad_per_s" || parameter == "servo_hz" ||
           parameter == "delay_periods" || parameter == "speed_m_per_s";
}

std::string wrong_variable(const Protocol &protocol) {
    const Variable &variable = protocol.variable;
    const ParameterFacts &parameter = variable_of(protocol);
    if (std::string wrong = unless_from_to("variable.standard", variable.standard,
                                           parameter.minimum, parameter.maximum);
        !wrong.empty()) {
        return wrong;
    }
    if (!acts_in(protocol.stimulus, parameter.name)) {
        return fmt::format("variable.parameter is {}; it must be one that is felt in a {}",
                           parameter.name,
                           kStimulusFormNames[static_cast<std::size_t>(protocol.stimulus)]);
    }
    if (!variable.standard_condition.empty() && !standard_condition_of(protocol)) {
        return fmt::format(
            "variable.standard_condition is \"{}\"; it must be one of the conditions: {}",
            variable.standard_condition, names_of(protocol.conditions));
    }
    if (protocol.task.kind == TaskKind::forced_choice_by_place &&
        parameter.of_condition != &Condition::turn_deg) {
        return fmt::format("variable.parameter is {}; it must be turn_deg, as the places of this "
                           "task are directions",
                           parameter.name);
    }
    for (const double level : presentable_levels(protocol)) {
        const double value = value_at(protocol, level);
        if (!(value >= parameter.minimum && value <= parameter.maximum)) {
            return fmt::format("method presents level {:g}, where {} is {:g}; it must be from {:g} "
                               "to {:g}",
                               level, parameter.name, value, parameter.minimum, parameter.maximum);
        }
    }
    return {};
}

std::string wrong_free_space(const Protocol &protocol) {
    if (protocol.free_space_is_stimulus && protocol.free_space) {
        return "free_space is given though free_space_is_stimulus is true; it must be left out, as "
               "each condition has its own";
    }
    if (protocol.stimulus == StimulusForm::stroke && !protocol.free_space_is_stimulus) {
        return "free_space_is_stimulus is false; it must be true for a stroke, which is felt in "
               "free space";
    }
    return {};
}

std::string wrong_blocks(const Protocol &protocol) {
    for (std::size_t i = 0; i < protocol.blocks.size(); ++i) {
        const ProtocolBlock &block = protocol.blocks[i];
        const std::set<std::size_t> different(block.conditions.begin(), block.conditions.end());
        if (different.size() != block.conditions.size()) {
            return fmt::format("block \"{}\" has a condition twice; it must have each of its "
                               "conditions once",
                               block.name);
        }
        if (std::string wrong = validate(block_of(protocol, i, true)); !wrong.empty()) {
            return wrong;
        }
    }
    const std::string order =
        validate(protocol.counterbalancing, static_cast<int>(protocol.blocks.size()));
    return order.empty() ? order : "counterbalancing: " + order;
}

std::string wrong_responses(const Protocol &protocol) {
    constexpr std::array<std::string_view, 4> kStops{"space", "escape", "f12", " "};
    const std::vector<std::string> &keys = protocol.responses.keys;
    const std::size_t needed = is_forced_choice(protocol.task.kind)
                                   ? static_cast<std::size_t>(protocol.task.alternatives)
                               : protocol.task.kind == TaskKind::yes_no ? 2
                                                                        : 3;
    if (keys.size() != needed) {
        return fmt::format("responses.keys has {}; it must have {} for this task", keys.size(),
                           needed);
    }
    std::vector<std::string> names = keys;
    for (std::string &name : names) {
        std::ranges::transform(name, name.begin(), [](char c) {
            return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
        });
    }
    for (std::size_t i = 0; i < keys.size(); ++i) {
        const std::string &name = names[i];
        if (std::ranges::count(kStops, name) > 0) {
            return fmt::format("responses.keys has \"{}\"; it must be no key that stops the device "
                               "or leaves the screen",
                               keys[i]);
        }
        if (name.empty() || std::ranges::count(names, name) > 1) {
            return fmt::format("responses.keys has \"{}\"; each must have a name of its own",
                               keys[i]);
        }
    }
    return {};
}

} // namespace

bool operator==(const Condition &a, const Condition &b) {
    const bool same_spot =
        a.spot.has_value() == b.spot.has_value() &&
        (!a.spot || (a.spot->point_m == b.spot->point_m && a.spot->normal == b.spot->normal));
    return same_spot && a.name == b.name && a.scene == b.scene && a.hold == b.hold &&
           a.tuning == b.tuning &&
           std::ranges::all_of(kConditionParameters, [&](const Field<Condition> &one) {
               return one.number(a) == one.number(b);
           });
}

std::span<const ParameterFacts> condition_parameters() {
    static const std::vector<ParameterFacts> all = all_parameters();
    return all;
}

const ParameterFacts *condition_parameter_named(std::string_view name) {
    const std::span<const ParameterFacts> all = condition_parameters();
    const auto found = std::ranges::find(all, name, &ParameterFacts::name);
    return found == all.end() ? nullptr : &*found;
}

Vector3 turn_axis(const Vector3 &normal, double turn_axis_deg) {
    const double kNearly = std::cos(1.0 * kRadiansPerDegree);
    const Vector3 from = std::abs(normal.x()) < kNearly ? Vector3::UnitX() : Vector3::UnitZ();
    const Vector3 at_zero = (from - from.dot(normal) * normal).normalized();
    return Eigen::AngleAxisd(turn_axis_deg * kRadiansPerDegree, normal) * at_zero;
}

Vector3 turned(const Condition &condition, const Vector3 &normal) {
    return Eigen::AngleAxisd(condition.turn_deg * kRadiansPerDegree,
                             turn_axis(normal, condition.turn_axis_deg)) *
           normal;
}

const ParameterFacts &variable_of(const Protocol &protocol) {
    const ParameterFacts *const parameter = condition_parameter_named(protocol.variable.parameter);
    SPRINGDRIVE_ASSERT(parameter != nullptr);
    return *parameter;
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

std::optional<std::size_t> condition_named(const Protocol &protocol, std::string_view name) {
    const auto found = std::ranges::find(protocol.conditions, name, &Condition::name);
    return found == protocol.conditions.end()
               ? std::nullopt
               : std::optional(static_cast<std::size_t>(found - protocol.conditions.begin()));
}

std::optional<std::size_t> standard_condition_of(const Protocol &protocol) {
    return condition_named(protocol, protocol.variable.standard_condition); // none has no name
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
            protocol.marking.max_marked};
}

std::vector<double> presentable_levels(const Protocol &protocol, int steps) {
    std::vector<double> levels = levels_of(protocol.method, steps);
    const auto add = [&levels](const std::vector<double> &more) {
        levels.insert(levels.end(), more.begin(), more.end());
    };
    if (const auto *staircases = std::get_if<Staircases>(&protocol.method)) {
        add(staircases->start_levels);
    }
    if (protocol.practice.max_trials > 0) {
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

std::string validate(const Protocol &protocol) {
    const auto under = [](std::string_view table, const std::string &wrong) {
        return wrong.empty() ? wrong : fmt::format("{}.{}", table, wrong);
    };
    if (std::string wrong =
            first_of({under("texts", validate(protocol.texts)), wrong_free_space(protocol),
                      under("task", validate(protocol.task)),
                      under("method", validate(protocol.method, protocol.task))});
        !wrong.empty()) {
        return wrong; // the others rely on these
    }
    return first_of(
        {wrong_variable(protocol), wrong_blocks(protocol), wrong_responses(protocol),
         protocol.expected ? under("expected", validate(expected_observer(protocol)))
                           : std::string(),
         protocol.windings.to_C > protocol.windings.from_C
             ? std::string()
             : fmt::format("windings.to_C is {:g}; it must be above windings.from_C, {:g}",
                           protocol.windings.to_C, protocol.windings.from_C)});
}

} // namespace springdrive::study
