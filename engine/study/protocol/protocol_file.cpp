#include "engine/study/protocol/protocol_file.h"

#include "base/input_error.h"
#include "base/input_file.h"
#include "base/strict_toml.h"
#include "engine/study/protocol/toml_tables.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

namespace springdrive::study {

namespace {

constexpr std::size_t kMostConditions = 100;
constexpr std::size_t kMostBlocks = 100;

/// In metres, from the device's zero pose: more than any device reaches.
constexpr double kFarthest_m = 2.0;

/// The parameters of a condition that are there; the others keep what `into` has.
void read_parameters(StrictTomlTable &table, Condition &into) {
    read_text(table, "scene", into.scene);
    read_choice(table, "hold", kHoldNames, into.hold);
    read_choice(table, "map", control::kMotionMapNames, into.tuning.map);
    read_choice(table, "alpha_mode", control::kAlphaModeNames, into.tuning.alpha_mode);
    for (const ParameterFacts &parameter : condition_parameters()) {
        if (table.has_optional(parameter.name)) {
            parameter.set(into,
                          table.number(parameter.name, {parameter.minimum, parameter.maximum}));
        }
    }
    if (!table.has_optional("point_m") && !table.has_optional("normal")) {
        return;
    }
    scene::TouchSpot spot;
    spot.point_m = table.vector("point_m", {-kFarthest_m, kFarthest_m});
    spot.normal = table.vector("normal", {-1e3, 1e3});
    if (!(spot.normal.norm() > 1e-6)) {
        table.refuse("normal", "has no length; it must point out of the surface");
    }
    spot.normal.normalize();
    into.spot = spot;
}

void read_conditions(StrictTomlTable &file, Protocol &protocol) {
    Condition common;
    if (file.has_optional("common")) {
        StrictTomlTable table = file.table("common");
        read_parameters(table, common);
        table.refuse_unknown_keys();
    }
    file.rows("condition", kMostConditions, [&](StrictTomlTable &table) {
        Condition condition = common;
        condition.name = table.text("name");
        read_parameters(table, condition);
        table.refuse_unknown_keys();
        if (condition.name.empty()) {
            table.refuse("name", "is empty; each condition must have one");
        }
        if (std::ranges::count(protocol.conditions, condition.name, &Condition::name) > 0) {
            table.refuse("name", "is \"" + condition.name +
                                     "\" like that of another; each must have its own");
        }
        protocol.conditions.push_back(std::move(condition));
    });
}

std::string names_of_conditions(const Protocol &protocol) {
    std::string names;
    for (const Condition &condition : protocol.conditions) {
        names += (names.empty() ? "" : ", ") + condition.name;
    }
    return names;
}

std::size_t condition_named(const Protocol &protocol, StrictTomlTable &table, std::string_view key,
                            const std::string &name) {
    const auto found = std::ranges::find(protocol.conditions, name, &Condition::name);
    if (found == protocol.conditions.end()) {
        table.refuse(key, "has \"" + name + "\"; it must be one of the conditions: " +
                              names_of_conditions(protocol));
    }
    return static_cast<std::size_t>(found - protocol.conditions.begin());
}

void read_variable(StrictTomlTable &file, Protocol &protocol) {
    StrictTomlTable table = file.table("variable");
    Variable &variable = protocol.variable;
    std::vector<std::string_view> names;
    for (const ParameterFacts &one : condition_parameters()) {
        names.push_back(one.name);
    }
    const ParameterFacts &parameter = condition_parameters()[table.choice("parameter", names)];
    variable.parameter = parameter.name;
    read_choice(table, "level", kLevelMeaningNames, variable.level);
    variable.standard = table.number("standard", {parameter.minimum, parameter.maximum});
    if (table.has_optional("standard_condition")) {
        variable.standard_condition = table.text("standard_condition");
        static_cast<void>(
            condition_named(protocol, table, "standard_condition", variable.standard_condition));
    }
    if (table.has_optional("shows_standard")) {
        variable.shows_standard = table.flag("shows_standard");
    }
    table.refuse_unknown_keys();
}

void read_blocks(StrictTomlTable &file, Protocol &protocol) {
    if (!file.has_optional("block")) {
        ProtocolBlock all{"all", std::vector<std::size_t>(protocol.conditions.size())};
        std::iota(all.conditions.begin(), all.conditions.end(), std::size_t{0});
        protocol.blocks.push_back(std::move(all));
        return;
    }
    file.rows("block", kMostBlocks, [&protocol](StrictTomlTable &table) {
        ProtocolBlock block;
        block.name = table.text("name");
        for (const std::string &name : table.texts("conditions", kMostConditions)) {
            block.conditions.push_back(condition_named(protocol, table, "conditions", name));
        }
        table.refuse_unknown_keys();
        protocol.blocks.push_back(std::move(block));
    });
}

void read_responses(StrictTomlTable &file, Protocol &protocol) {
    if (file.has_optional("responses")) {
        StrictTomlTable table = file.table("responses");
        read_choice(table, "device", kResponseDeviceNames, protocol.responses.device);
        if (table.has_optional("keys")) {
            protocol.responses.keys = table.texts("keys", 10);
        }
        table.refuse_unknown_keys();
    }
}

/// A table of nothing but numbers, if it is there.
template <typename Table, std::size_t count>
void read_table(StrictTomlTable &file, std::string_view name,
                const std::array<NumberKey<Table>, count> &keys, Table &into) {
    if (file.has_optional(name)) {
        StrictTomlTable table = file.table(name);
        read_numbers(table, keys, into);
        table.refuse_unknown_keys();
    }
}

void read_marking(StrictTomlTable &file, Marking &marking) {
    if (file.has_optional("marking")) {
        StrictTomlTable table = file.table("marking");
        read_numbers(table, kMarkingKeys, marking);
        if (table.has_optional("repeats")) {
            marking.repeats = table.flag("repeats");
        }
        table.refuse_unknown_keys();
    }
}

void read_expectation(StrictTomlTable &file, Protocol &protocol) {
    if (file.has_optional("expected")) {
        StrictTomlTable table = file.table("expected");
        Expectation expected;
        static_cast<void>(table.number("threshold", {-kLargestLevel, kLargestLevel}));
        read_numbers(table, kExpectationKeys, expected);
        read_choice(table, "shape", kShapeNames, expected.family.shape);
        read_choice(table, "scale", kScaleNames, expected.family.scale);
        expected.source = table.text("source");
        table.refuse_unknown_keys();
        protocol.expected = std::move(expected);
    }
}

Protocol protocol_in(StrictTomlTable file) {
    Protocol protocol;
    protocol.title = file.text("title");
    read_text(file, "title", protocol.title);
    read_text(file, "language", protocol.language);
    read_text(file, "device", protocol.device_file);
    read_numbers(file, kProtocolKeys, protocol);
    protocol.stimulus = static_cast<StimulusForm>(file.choice("stimulus", kStimulusFormNames));
    read_choice(file, "counterbalancing", kCounterbalancingNames, protocol.counterbalancing);
    if (file.has_optional("free_space_is_stimulus")) {
        protocol.free_space_is_stimulus = file.flag("free_space_is_stimulus");
    }
    if (file.has_optional("free_space")) {
        StrictTomlTable table = file.table("free_space");
        protocol.free_space.emplace();
        read_numbers(table, kFreeSpaceKeys, *protocol.free_space);
        table.refuse_unknown_keys();
    }
    read_for_participant(file, protocol);
    read_conditions(file, protocol);
    read_variable(file, protocol);
    read_procedure(file, protocol);
    read_blocks(file, protocol);
    read_responses(file, protocol);
    read_table(file, "timing", kTimingKeys, protocol.timing);
    read_table(file, "breaks", kBreakKeys, protocol.breaks);
    read_marking(file, protocol.marking);
    read_table(file, "windings", kWindingKeys, protocol.windings);
    read_table(file, "stopping", kStoppingKeys, protocol.stopping);
    read_expectation(file, protocol);
    file.refuse_unknown_keys();
    refuse_as(file, what_is_wrong_with(protocol));
    return protocol;
}

} // namespace

Protocol read_protocol_file(const std::filesystem::path &file) {
    return protocol_in(StrictTomlTable::read(file));
}

Protocol read_protocol_text(const std::string &text, const std::filesystem::path &file) {
    return protocol_in(StrictTomlTable::parse(text, file));
}

} // namespace springdrive::study
