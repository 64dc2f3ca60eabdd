#include "engine/study/protocol/protocol_keys.h"

#include "base/print.h"
#include "engine/study/protocol/toml_tables.h"

#include <fmt/core.h>

#include <array>
#include <cstddef>
#include <ostream>
#include <span>
#include <utility>

namespace springdrive::study {

namespace {

constexpr std::string_view kRequired = "required";

class KeyList {
public:
    void in(std::string_view table) { table_ = table; }

    void add(std::string_view key, std::string allowed, std::string default_value,
             std::string_view help) {
        keys_.push_back({table_, std::string(key), "–", std::move(allowed),
                         std::move(default_value), std::string(help)});
    }

    void add_choice(std::string_view key, std::span<const std::string_view> names,
                    std::string default_value, std::string_view help) {
        std::string all;
        for (const std::string_view name : names) {
            all += fmt::format("{}\"{}\"", all.empty() ? "" : ", ", name);
        }
        add(key, std::move(all), std::move(default_value), help);
    }

    template <typename Table, std::size_t count>
    void add_numbers(const std::array<NumberKey<Table>, count> &numbers) {
        static const Table by_default{};
        for (const NumberKey<Table> &one : numbers) {
            add_number(one.key, one.unit, one.minimum, one.maximum,
                       fmt::format("{:g}", one.of(by_default)), one.help);
            keys_.back().allowed += one.whole != nullptr ? ", whole" : "";
        }
    }

    template <typename Table, std::size_t count>
    void add_required_numbers(const std::array<NumberKey<Table>, count> &numbers) {
        add_numbers(numbers);
        for (std::size_t i = keys_.size() - count; i < keys_.size(); ++i) {
            keys_[i].default_value = kRequired;
        }
    }

    void add_parameters() {
        for (const ParameterFacts &one : condition_parameters()) {
            add_number(one.name, one.unit, one.minimum, one.maximum,
                       fmt::format("{:g}", one.default_value), one.help);
        }
    }

    std::vector<KeyFacts> take() { return std::move(keys_); }

private:
    void add_number(std::string_view key, std::string_view unit, double minimum, double maximum,
                    std::string default_value, std::string_view help) {
        keys_.push_back({table_, std::string(key), std::string(unit),
                         fmt::format("{:g} to {:g}", minimum, maximum), std::move(default_value),
                         std::string(help)});
    }

    std::string table_;
    std::vector<KeyFacts> keys_;
};

std::string in_toml(std::string_view name) { return fmt::format("\"{}\"", name); }

void add_study(KeyList &list) {
    const Protocol by_default;
    list.add("title", "text", std::string(kRequired), "of the study, for the experimenter");
    list.add("language", "text", in_toml(by_default.language), "of the texts");
    list.add("device", "text", in_toml(by_default.device_file),
             "an included device, by its name, or a device file beside the protocol");
    list.add_choice("stimulus", kStimulusFormNames, std::string(kRequired),
                    "press: the hand presses with `press_N`; blow: it strikes with "
                    "`speed_m_per_s`; pulse: it rests with `press_N` and the device pushes; "
                    "stroke: it moves in free space");
    list.add("free_space_is_stimulus", "true, false", "false",
             "true: conditions may differ in free space, which is what is judged");
    list.add_choice(
        "counterbalancing", kCounterbalancingNames,
        in_toml(kCounterbalancingNames[static_cast<std::size_t>(by_default.counterbalancing)]),
        "of the blocks, by the participant's number");
    list.add_numbers(kProtocolKeys);
    list.in("texts");
    for (const ParticipantText &one : kParticipantTexts) {
        list.add(one.key, "text", "English", "what the participant reads " + std::string(one.help));
    }
    list.in("free_space");
    list.add_numbers(kFreeSpaceKeys);
}

void add_condition_keys(KeyList &list) {
    const Condition by_default;
    list.add("scene", "text", in_toml(by_default.scene),
             "an included scene, by its name; a .gltf or .glb file beside the protocol; or "
             "\"none\", for free space");
    list.add("point_m", "three numbers", "the scene's own spot",
             "the spot, on the surface, in device coordinates [m]; with `normal`");
    list.add("normal", "three numbers", "the scene's own spot",
             "out of the surface there; of any length");
    list.add_choice("hold", kHoldNames, in_toml(kHoldNames[0]),
                    "surface: the scene, without friction; cup: x₀ stays where the tip touches");
    list.add_choice("map", control::kMotionMapNames, in_toml(name_of(by_default.tuning.map)),
                    "motion map: (18) or (23)");
    list.add_choice("alpha_mode", control::kAlphaModeNames,
                    in_toml(name_of(by_default.tuning.alpha_mode)), "source of α in (23)");
    list.add_parameters();
}

void add_conditions(KeyList &list) {
    list.in("common");
    add_condition_keys(list);
    list.in("condition");
    list.add("name", "text", std::string(kRequired), "in results");
    list.in("variable");
    list.add("parameter", "a parameter of conditions", std::string(kRequired),
             "the one that the method varies");
    list.add_choice("level", kLevelMeaningNames, in_toml(kLevelMeaningNames[0]),
                    "what a level of the method is: the parameter's value, what is added to the "
                    "standard's, or what is taken off it");
    list.add("standard", "as the parameter", std::string(kRequired),
             "the parameter's value in the stimulus that is compared with");
    list.add("standard_condition", "name of a condition", "each with itself",
             "the condition that all are compared with");
    list.add("shows_standard", "true, false", "false",
             "yes/no and adjustment: the standard is presented before the comparison");
}

void add_procedure(KeyList &list) {
    list.in("task");
    list.add_choice("kind", kTaskKindNames, std::string(kRequired), "what is asked in a trial");
    list.add_numbers(kTaskKeys);
    list.in("method");
    list.add_choice("kind", kMethodNames, std::string(kRequired), "which level comes next");
    list.add_choice("scale", kScaleNames, "of the kind",
                    "staircases, quest_plus, adjustment: on which levels are stepped and fitted");
    list.add_choice("shape", kShapeNames, in_toml(kShapeNames[2]),
                    "quest_plus: of the psychometric function");
    list.add("levels", "numbers, rising", std::string(kRequired),
             "constant_stimuli, quest_plus: that are presented");
    list.add("start_levels", "numbers", std::string(kRequired),
             "staircases: one for each track; tracks are interleaved");
    list.add_numbers(kConstantStimuliKeys);
    list.add_numbers(kStaircaseKeys);
    list.add_numbers(kQuestPlusKeys);
    // The first two of adjustment are those of staircases.
    list.add_numbers(std::array{kAdjustmentKeys[2], kAdjustmentKeys[3], kAdjustmentKeys[4]});
    list.in("method.steps");
    list.add_numbers(kStepKeys);
    list.in("method.threshold");
    list.add_choice("scale", kScaleNames, "the method's; of the slope logarithmic",
                    "on which the density is one");
    list.add_choice("density", kDensityNames, in_toml(kDensityNames[0]),
                    "of what is thought likely");
    list.add_numbers(kPriorKeys);
    list.add_numbers(kPriorAxisKeys);
    list.in("practice");
    list.add("levels", "numbers", "none", "drawn from by chance");
    list.add_numbers(kPracticeKeys);
    list.in("catch_trials");
    list.add("levels", "numbers", "none", "drawn from by chance");
    list.add_numbers(kCatchTrialKeys);
    list.in("block");
    list.add("name", "text", std::string(kRequired), "in results");
    list.add("conditions", "names of conditions", std::string(kRequired),
             "whose trials are interleaved in it; without any [[block]] there is one of all");
    list.in("responses");
    list.add_choice("device", kResponseDeviceNames, in_toml(kResponseDeviceNames[0]),
                    "with which is answered");
    list.add("keys", "texts", R"("1", "2")",
             "one for each alternative; no, yes; or less, more, done of an adjustment");
}

void add_session(KeyList &list) {
    list.in("timing");
    list.add_numbers(kTimingKeys);
    list.in("breaks");
    list.add_numbers(kBreakKeys);
    list.in("marking");
    list.add_numbers(kMarkingKeys);
    list.add("repeats", "true, false", "true", "marked trials are presented again");
    list.in("windings");
    list.add_numbers(kWindingKeys);
    list.in("stopping");
    list.add_numbers(kStoppingKeys);
    list.in("noise");
    list.add_numbers(kNoiseKeys);
    list.in("expected");
    list.add_numbers(kExpectationKeys);
    list.add_choice("shape", kShapeNames, in_toml(kShapeNames[2]), "of the psychometric function");
    list.add_choice("scale", kScaleNames, in_toml(kScaleNames[1]), "of the psychometric function");
    list.add("source", "text", std::string(kRequired), "where that is from");
}

void add_questions(KeyList &list) {
    list.in("questions");
    list.add("name", "a-z, 0-9, _", std::string(kRequired), "of its column in tables of answers");
    list.add_choice("when", kQuestionnaireTimeNames, std::string(kRequired),
                    "the session's first trial, or its last");
    list.add("text", "text", std::string(kRequired), "what is asked");
    list.add_choice("kind", kQuestionnaireKindNames, std::string(kRequired),
                    "how it is answered: a free text, a whole number, or one of several texts");
    list.add_required_numbers(kQuestionKeys);
    list.add("lowest_label", "text", std::string(kRequired), "scale: what its lowest number means");
    list.add("highest_label", "text", std::string(kRequired), "scale: and its highest");
    list.add("choices", "2 to 20 texts", std::string(kRequired), "choice: the possible answers");
}

/// The line above the keys of a table.
std::string heading(std::string_view table) {
    if (table.empty()) {
        return "Before all tables:";
    }
    if (table == "common") {
        return "`[common]`, for all conditions, and `[[condition]]`, for one:";
    }
    if (table == "condition") {
        return "`[[condition]]` only:";
    }
    if (table == "method.threshold") {
        return "`[method.threshold]`, `[method.slope]`, `[method.guess]` and `[method.lapse]` of "
               "quest_plus, the last two optional:";
    }
    const bool is_row = table == "block" || table == "method.steps" || table == "questions";
    return is_row ? fmt::format("`[[{}]]`:", table) : fmt::format("`[{}]`:", table);
}

} // namespace

std::vector<KeyFacts> protocol_keys() {
    KeyList list;
    add_study(list);
    add_conditions(list);
    add_procedure(list);
    add_session(list);
    add_questions(list);
    return list.take();
}

void write_protocol_keys(std::ostream &out) {
    std::string_view table = "none yet";
    const std::vector<KeyFacts> keys = protocol_keys();
    for (const KeyFacts &key : keys) {
        if (key.table != table) {
            table = key.table;
            print(out,
                  "\n{}\n\n| key | unit | allowed | default | meaning |\n| --- | --- | --- | --- | "
                  "--- |\n",
                  heading(table));
        }
        print(out, "| `{}` | {} | {} | {} | {} |\n", key.key, key.unit, key.allowed,
              key.default_value, key.help);
    }
}

} // namespace springdrive::study
