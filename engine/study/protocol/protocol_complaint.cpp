#include "engine/study/methods/wrong_value.h"
#include "engine/study/protocol/analysis_plan.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/protocol_keys.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string_view>

namespace springdrive::study {

namespace {

std::string wrong_texts(const Protocol &protocol) {
    const std::string wrong = what_is_wrong_with(protocol.texts);
    return wrong.empty() ? wrong : "texts." + wrong;
}

/// The first number of a table that is out of its range.
template <typename Table, std::size_t count>
std::string wrong_number(std::string_view name, const std::array<NumberKey<Table>, count> &keys,
                         const Table &table) {
    for (const NumberKey<Table> &key : keys) {
        const std::string whole_name =
            name.empty() ? std::string(key.key) : fmt::format("{}.{}", name, key.key);
        if (std::string wrong = unless_from_to(whole_name, key.of(table), key.minimum, key.maximum);
            !wrong.empty()) {
            return wrong;
        }
    }
    return {};
}

std::string wrong_numbers(const Protocol &protocol) {
    return first_of(
        {wrong_number("", kProtocolKeys, protocol),
         wrong_number("timing", kTimingKeys, protocol.timing),
         wrong_number("breaks", kBreakKeys, protocol.breaks),
         wrong_number("marking", kMarkingKeys, protocol.marking),
         wrong_number("windings", kWindingKeys, protocol.windings),
         wrong_number("stopping", kStoppingKeys, protocol.stopping),
         protocol.free_space ? wrong_number("free_space", kFreeSpaceKeys, *protocol.free_space)
                             : std::string(),
         protocol.noise ? wrong_number("noise", kNoiseKeys, *protocol.noise) : std::string(),
         protocol.expected ? wrong_number("expected", kExpectationKeys, *protocol.expected)
                           : std::string()});
}

std::string wrong_condition(const Condition &condition) {
    const std::string name = fmt::format("condition \"{}\"", condition.name);
    for (const ParameterFacts &parameter : condition_parameters()) {
        if (std::string wrong = unless_from_to(parameter.name, parameter.get(condition),
                                               parameter.minimum, parameter.maximum);
            !wrong.empty()) {
            return fmt::format("{}: {}", name, wrong);
        }
    }
    if (condition.spot && !(std::abs(condition.spot->normal.norm() - 1.0) < 1e-9 &&
                            condition.spot->point_m.allFinite())) {
        return name + ": normal has another length than 1; it must be a unit vector";
    }
    return {};
}

std::string wrong_conditions(const Protocol &protocol) {
    if (protocol.conditions.empty()) {
        return "condition is missing; there must be at least one";
    }
    std::set<std::string_view> names;
    for (const Condition &condition : protocol.conditions) {
        if (condition.name.empty() || !names.insert(condition.name).second) {
            return fmt::format("condition \"{}\" is there twice or has no name; each must have its "
                               "own",
                               condition.name);
        }
        if (std::string wrong = wrong_condition(condition); !wrong.empty()) {
            return wrong;
        }
    }
    return {};
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
    const ParameterFacts *const parameter = condition_parameter_named(variable.parameter);
    if (parameter == nullptr) {
        return fmt::format("variable.parameter is \"{}\"; it must be a parameter of conditions",
                           variable.parameter);
    }
    if (!acts_in(protocol.stimulus, parameter->name)) {
        return fmt::format("variable.parameter is {}; it must be one that is felt in a {}",
                           parameter->name,
                           kStimulusFormNames[static_cast<std::size_t>(protocol.stimulus)]);
    }
    if (std::string wrong = unless_from_to("variable.standard", variable.standard,
                                           parameter->minimum, parameter->maximum);
        !wrong.empty()) {
        return wrong;
    }
    if (!variable.standard_condition.empty() && !standard_condition_of(protocol)) {
        return fmt::format(
            "variable.standard_condition is \"{}\"; it must be one of the conditions",
            variable.standard_condition);
    }
    if (protocol.task.kind == TaskKind::forced_choice_by_place &&
        parameter->of_condition != &Condition::turn_deg) {
        return fmt::format("variable.parameter is {}; it must be turn_deg, as the places of this "
                           "task are directions",
                           parameter->name);
    }
    for (const double level : presentable_levels(protocol)) {
        const double value = value_at(protocol, level);
        if (!(value >= parameter->minimum && value <= parameter->maximum)) {
            return fmt::format("method presents level {:g}, where {} is {:g}; it must be from {:g} "
                               "to {:g}",
                               level, parameter->name, value, parameter->minimum,
                               parameter->maximum);
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
    if (protocol.blocks.empty()) {
        return "block is missing; there must be at least one";
    }
    std::set<std::string_view> names;
    for (std::size_t i = 0; i < protocol.blocks.size(); ++i) {
        const ProtocolBlock &block = protocol.blocks[i];
        if (block.name.empty() || !names.insert(block.name).second) {
            return fmt::format("block \"{}\" is there twice or has no name; each must have its own",
                               block.name);
        }
        const std::set<std::size_t> different(block.conditions.begin(), block.conditions.end());
        if (block.conditions.empty() || different.size() != block.conditions.size() ||
            *different.rbegin() >= protocol.conditions.size()) {
            return fmt::format("block \"{}\" has no condition, or one twice; it must have each of "
                               "its conditions once",
                               block.name);
        }
        if (std::string wrong = what_is_wrong_with(block_of(protocol, i, true)); !wrong.empty()) {
            return wrong;
        }
    }
    const std::string order =
        what_is_wrong_with(protocol.counterbalancing, static_cast<int>(protocol.blocks.size()));
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

std::string wrong_expectation(const Protocol &protocol) {
    const std::string wrong =
        protocol.expected ? what_is_wrong_with(expected_observer(protocol)) : std::string();
    return wrong.empty() ? wrong : "expected." + wrong;
}

} // namespace

std::string what_is_wrong_with(const Protocol &protocol) {
    if (protocol.title.empty()) {
        return "title is empty; the study must have one";
    }
    // In this order: later ones rely on what is right before.
    for (const auto check : {wrong_texts, wrong_numbers, wrong_conditions, wrong_free_space}) {
        if (std::string wrong = check(protocol); !wrong.empty()) {
            return wrong;
        }
    }
    if (std::string wrong = what_is_wrong_with(protocol.task); !wrong.empty()) {
        return "task." + wrong;
    }
    if (std::string wrong = what_is_wrong_with(protocol.method, protocol.task); !wrong.empty()) {
        return "method." + wrong;
    }
    for (const auto check : {wrong_variable, wrong_blocks, wrong_responses, wrong_expectation}) {
        if (std::string wrong = check(protocol); !wrong.empty()) {
            return wrong;
        }
    }
    if (std::string wrong = what_is_wrong_with(protocol.questionnaire); !wrong.empty()) {
        return wrong;
    }
    if (protocol.windings.to_C <= protocol.windings.from_C) {
        return fmt::format("windings.to_C is {:g}; it must be above windings.from_C, {:g}",
                           protocol.windings.to_C, protocol.windings.from_C);
    }
    return {};
}

} // namespace springdrive::study
