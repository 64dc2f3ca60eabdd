#include "engine/study/protocol/protocol.h"

#include "base/field.h"
#include "base/field_toml.h"
#include "base/text.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <optional>
#include <ostream>
#include <string_view>
#include <utility>

namespace springdrive::study {

namespace {

// The values of a protocol's own tables, as files and the manual have them. Those of tasks and
// methods are in engine/study/methods, of conditions, texts and questions beside these.

/// Before all tables.
constexpr auto kProtocolFields = std::to_array<Field<Protocol>>({
    {"title", &Protocol::title, "of the study, for the experimenter", kReadable, "", kRequired},
    {"language", &Protocol::language, "of the texts", kReadable},
    {"device", &Protocol::device_file,
     "an included device, by its name, or a device file beside the protocol", kReadable},
    {"stimulus", choice_of<&Protocol::stimulus>(kStimulusFormNames),
     "press: the hand presses with `press_N`; blow: it strikes with `speed_m_per_s`; pulse: it "
     "rests with `press_N` and the device pushes; stroke: it moves in free space",
     kRequired},
    {"free_space_is_stimulus", &Protocol::free_space_is_stimulus,
     "true: conditions may differ in free space, which is what is judged"},
    {"counterbalancing", choice_of<&Protocol::counterbalancing>(kCounterbalancingNames),
     "of the blocks, by the participant's number"},
    {"seed", &Protocol::seed, "of everything that is drawn by chance", 0.0, 2'147'483'647.0},
    {"participants", &Protocol::participants, "how many are to take part", 1.0, 10'000.0},
});

/// The range of one of the control law's parameters.
constexpr NumberRange range_of(double control::Tuning::*value) {
    const control::Parameter &parameter = control::parameter_of(value);
    return {parameter.minimum, parameter.maximum};
}

constexpr auto kFreeSpaceFields = std::to_array<Field<FreeSpaceTuning>>({
    {"dR_Ohm", &FreeSpaceTuning::dR_Ohm,
     "residual winding resistance of all conditions in free space",
     range_of(&control::Tuning::dR_Ohm), "Ω"},
    {"lambda_rad_per_s", &FreeSpaceTuning::lambda_rad_per_s,
     "cutoff of the velocity filter in free space, at the first condition's servo rate and delay; "
     "at others the one with the same lag",
     range_of(&control::Tuning::lambda_rad_per_s), "rad/s"},
});

/// Of `condition_parameters()`.
constexpr auto kParameterNames = [] {
    std::array<std::string_view, control::kParameters.size() + kConditionParameters.size()> names;
    const auto gains =
        std::ranges::transform(control::kParameters, names.begin(), &control::Parameter::name);
    std::ranges::transform(kConditionParameters, gains.out, &Field<Condition>::name);
    return names;
}();

constexpr auto kVariableFields = std::to_array<Field<Variable>>({
    {"parameter",
     Choice<Variable>{kParameterNames,
                      [](const Variable &variable) {
                          const auto found = std::ranges::find(kParameterNames, variable.parameter);
                          return static_cast<std::size_t>(found - kParameterNames.begin());
                      },
                      [](Variable &variable, std::size_t number) {
                          variable.parameter = kParameterNames[number];
                      }},
     "of conditions, the one that the method varies", kRequired},
    {"level", choice_of<&Variable::level>(kLevelMeaningNames),
     "what a level of the method is: the parameter's value, what is added to the standard's, or "
     "what is taken off it"},
    {"standard", &Variable::standard,
     "the parameter's value in the stimulus that is compared with, within its range", kTypedLevel,
     "", kRequired},
    {"standard_condition", &Variable::standard_condition,
     "the condition that all are compared with; without it each with itself", kReadable, "",
     kDerived},
    {"shows_standard", &Variable::shows_standard,
     "yes/no and adjustment: the standard is presented before the comparison"},
});

/// Of [method], whatever its kind.
constexpr auto kMethodFields = std::to_array<Field<Protocol>>({
    {"kind",
     Choice<Protocol>{kMethodNames,
                      [](const Protocol &protocol) { return protocol.method.index(); },
                      [](Protocol &protocol, std::size_t kind) {
                          protocol.method = std::array<Method, 4>{ConstantStimuli(), Staircases(),
                                                                  QuestPlus(), Adjustment()}[kind];
                      }},
     "which level comes next", kRequired},
});

constexpr auto kBlockFields = std::to_array<Field<ProtocolBlock>>({
    {"name", &ProtocolBlock::name, "in results", kRequired},
});

constexpr auto kResponseFields = std::to_array<Field<ResponseWays>>({
    {"device", choice_of<&ResponseWays::device>(kResponseDeviceNames), "with which is answered"},
    {"keys", &ResponseWays::keys,
     "one for each alternative; no, yes; or less, more, done of an adjustment", 1.0, 10.0},
});

constexpr auto kTimingFields = std::to_array<Field<TrialTiming>>({
    {"rest_s", &TrialTiming::rest_s,
     "the hand must be at rest in free space at the spot for so long", 0.1, 10.0, "s"},
    {"approach_s", &TrialTiming::approach_s, "at most, until the hand is in contact", 0.2, 30.0,
     "s"},
    {"presentation_s", &TrialTiming::presentation_s,
     "of the stimulus in each interval; an adjustment takes so long", 0.05, 60.0, "s"},
    {"pause_s", &TrialTiming::pause_s, "between the intervals of a trial", 0.0, 60.0, "s"},
    {"response_s", &TrialTiming::response_s,
     "at most, after the last interval; then the trial is marked", 0.5, 600.0, "s"},
    {"between_trials_s", &TrialTiming::between_trials_s, "from an answer to the next trial", 0.0,
     60.0, "s"},
    {"expected_response_s", &TrialTiming::expected_response_s,
     "that an answer will take: only the session's length is reckoned with it", 0.1, 600.0, "s"},
});

constexpr auto kBreakFields = std::to_array<Field<Breaks>>({
    {"every_trials", &Breaks::every_trials, "a break within a block after so many trials; 0: none",
     0.0, 10'000.0},
    {"break_s", &Breaks::break_s, "the shortest; the participant may rest longer", 0.0, 3600.0,
     "s"},
    {"between_blocks_s", &Breaks::between_blocks_s, "the shortest break between two blocks", 0.0,
     3600.0, "s"},
});

constexpr auto kMarkingFields = std::to_array<Field<Marking>>({
    {"stiffness_percent", &Marking::stiffness_percent,
     "by which the delivered stiffness may differ from the intended one", 0.1, 100.0, "%"},
    {"direction_deg", &Marking::direction_deg,
     "by which the delivered force's direction may differ", 0.1, 90.0, "°"},
    {"force_percent", &Marking::force_percent,
     "by which the hand's press, or the speed of its blow or stroke, may differ", 1.0, 100.0, "%"},
    {"lateness_s", &Marking::lateness_s, "of deadlines that the servo missed in a row", 0.0, 0.05,
     "s"},
    {"most_marked", &Marking::max_marked,
     "marked trials of a block; with the next one it ends unfinished", 0.0, 1000.0},
    {"repeats", &Marking::repeats, "marked trials are presented again"},
});

constexpr auto kWindingFields = std::to_array<Field<WindingBand>>({
    {"air_C", &WindingBand::air_C, "air in the room", 10.0, 40.0, "°C"},
    {"from_C", &WindingBand::from_C, "to which the windings are warmed before the first trial",
     10.0, 90.0, "°C"},
    {"to_C", &WindingBand::to_C, "above which the next trial waits until they have cooled", 15.0,
     100.0, "°C"},
});

constexpr auto kStoppingFields = std::to_array<Field<StoppingRules>>({
    {"longest_session_min", &StoppingRules::longest_session_min,
     "after which the session ends with the present trial", 1.0, 480.0, "min"},
    {"most_trips", &StoppingRules::max_trips,
     "of the safety monitor; with the next one the session ends", 0.0, 100.0},
});

constexpr auto kNoiseFields = std::to_array<Field<MaskingNoise>>({
    {"level_dBFS", &MaskingNoise::level_dBFS,
     "RMS of the noise, of the sound output's full scale; the volume makes it comfortable", -80.0,
     -6.0, "dBFS"},
});

constexpr auto kExpectationFields = std::to_array<Field<Expectation>>({
    {"threshold", &Expectation::threshold, "α, a level; in the variable's unit", kTypedLevel, "",
     kRequired},
    {"slope", &Expectation::slope, "β, per unit of the scale", kMinRatioTyped, kMaxTyped},
    {"lapse", &Expectation::lapse, "λ: wrong answers however strong the stimulus", 0.0, 0.2},
    {"shape", choice_of<&Expectation::family, &FunctionFamily::shape>(kShapeNames),
     "of the psychometric function"},
    {"scale", choice_of<&Expectation::family, &FunctionFamily::scale>(kScaleNames),
     "of the psychometric function"},
    {"source", &Expectation::source, "where that is from", kRequired},
});

/// The tables that may be left out, which hold nothing but values: visit(NAME, FIELDS, VALUES).
template <typename Visit> void visit_tables(Protocol &protocol, const Visit &visit) {
    visit("texts", kTextFields, protocol.texts);
    visit("free_space", kFreeSpaceFields, protocol.free_space);
    visit("practice", kPracticeFields, protocol.practice);
    visit("catch_trials", kCatchTrialFields, protocol.catch_trials);
    visit("responses", kResponseFields, protocol.responses);
    visit("timing", kTimingFields, protocol.timing);
    visit("breaks", kBreakFields, protocol.breaks);
    visit("marking", kMarkingFields, protocol.marking);
    visit("windings", kWindingFields, protocol.windings);
    visit("stopping", kStoppingFields, protocol.stopping);
    visit("noise", kNoiseFields, protocol.noise);
    visit("expected", kExpectationFields, protocol.expected);
}

constexpr std::size_t kMaxRows = 100;

/// In metres, from the device's zero pose: more than any device reaches.
constexpr double kFarthest_m = 2.0;

/// A table that may be left out.
template <typename Fields, typename Struct>
void read_table(StrictTomlTable &file, std::string_view name, const Fields &fields, Struct &into) {
    if (file.has_optional(name)) {
        StrictTomlTable table = file.table(name);
        read(table, fields, into);
        table.refuse_unknown_keys();
    }
}

template <typename Fields, typename Struct>
void read_table(StrictTomlTable &file, std::string_view name, const Fields &fields,
                std::optional<Struct> &into) {
    if (file.has_optional(name)) {
        read_table(file, name, fields, into.emplace());
    }
}

/// Passes on an error of the values, "KEY is VALUE; it must be …", with the key's file and line;
/// KEY may lead into inner tables, "threshold.minimum". Does nothing with an empty one.
void refuse_as(StrictTomlTable &table, const std::string &error) {
    if (error.empty()) {
        return;
    }
    const std::size_t end = std::min(error.find(' '), error.size());
    const std::string key = error.substr(0, end);
    const std::size_t dot = key.find('.');
    if (dot != std::string::npos && table.has(key.substr(0, dot))) {
        StrictTomlTable inner = table.table(key.substr(0, dot));
        refuse_as(inner, error.substr(dot + 1));
    }
    table.refuse(key, error.substr(std::min(end + 1, error.size())));
}

/// Refuses a row whose name is empty or another's, or not told from others by eye.
template <typename Rows>
void check_name(const StrictTomlTable &row, const std::string &name, const Rows &others) {
    if (name.empty()) {
        row.refuse("name", "is empty; each must have one");
    }
    if (const std::string wrong = validate_name(name); !wrong.empty()) {
        row.refuse("name", "is \"" + name + "\", which " + wrong);
    }
    if (std::ranges::any_of(others, [&name](const auto &other) { return other.name == name; })) {
        row.refuse("name", "is \"" + name + "\" like that of another; each must have its own");
    }
}

/// The parameters of a condition that are there; the others keep what `into` has.
void read_parameters(StrictTomlTable &table, Condition &into) {
    read(table, kConditionFields, into);
    for (const ParameterFacts &parameter : condition_parameters()) {
        if (table.has_optional(parameter.name)) {
            parameter.set(into,
                          table.number(parameter.name, {parameter.minimum, parameter.maximum}));
        }
    }
    if (table.has_optional("point_m") || table.has_optional("normal")) {
        scene::TouchSpot &spot = into.spot.emplace();
        spot.point_m = table.vector("point_m", {-kFarthest_m, kFarthest_m});
        spot.normal = table.vector("normal", {-1e3, 1e3});
        if (!(spot.normal.norm() > 1e-6)) {
            table.refuse("normal", "has no length; it must point out of the surface");
        }
        spot.normal.normalize();
    }
}

void read_conditions(StrictTomlTable &file, Protocol &protocol) {
    Condition common;
    if (file.has_optional("common")) {
        StrictTomlTable table = file.table("common");
        read_parameters(table, common);
        table.refuse_unknown_keys();
    }
    file.rows("condition", kMaxRows, [&](StrictTomlTable &table) {
        Condition condition = common;
        read(table, kConditionName, condition);
        read_parameters(table, condition);
        table.refuse_unknown_keys();
        check_name(table, condition.name, protocol.conditions);
        protocol.conditions.push_back(std::move(condition));
    });
}

void read_blocks(StrictTomlTable &file, Protocol &protocol) {
    if (!file.has_optional("block")) {
        ProtocolBlock all{"all", std::vector<std::size_t>(protocol.conditions.size())};
        std::iota(all.conditions.begin(), all.conditions.end(), std::size_t{0});
        protocol.blocks.push_back(std::move(all));
        return;
    }
    file.rows("block", kMaxRows, [&protocol](StrictTomlTable &table) {
        ProtocolBlock block;
        read(table, kBlockFields, block);
        for (const std::string &name : table.texts("conditions", kMaxRows)) {
            const std::optional<std::size_t> condition = condition_named(protocol, name);
            if (!condition) {
                table.refuse("conditions", "has \"" + name +
                                               "\"; it must be one of the conditions: " +
                                               names_of(protocol.conditions));
            }
            block.conditions.push_back(*condition);
        }
        table.refuse_unknown_keys();
        check_name(table, block.name, protocol.blocks);
        protocol.blocks.push_back(std::move(block));
    });
}

void read_axis(StrictTomlTable table, PriorAxis &axis) {
    read(table, kPriorFields, axis.prior);
    read(table, kPriorAxisFields, axis);
    table.refuse_unknown_keys();
}

void read_method(StrictTomlTable &table, const Task &, ConstantStimuli &method) {
    read(table, kConstantStimuliFields, method);
}

void read_method(StrictTomlTable &table, const Task &, Staircases &method) {
    read(table, kStaircaseFields, method);
    table.rows("steps", kMaxRows, [&method](StrictTomlTable &row) {
        read(row, kStepFields, method.steps.emplace_back());
        row.refuse_unknown_keys();
    });
}

void read_method(StrictTomlTable &table, const Task &task, QuestPlus &method) {
    read(table, kQuestPlusFields, method);
    const GuessRange guess = guess_range(task);
    method.threshold.prior.scale = method.family.scale;
    method.slope.prior.scale = Scale::logarithmic;
    method.guess.prior.minimum = guess.minimum;
    method.guess.prior.maximum = guess.maximum;
    method.guess.points = guess.minimum == guess.maximum ? 1 : 5;
    method.lapse.prior = known(0.02);
    read_axis(table.table("threshold"), method.threshold);
    read_axis(table.table("slope"), method.slope);
    if (table.has_optional("guess")) {
        read_axis(table.table("guess"), method.guess);
    }
    if (table.has_optional("lapse")) {
        read_axis(table.table("lapse"), method.lapse);
    }
}

void read_method(StrictTomlTable &table, const Task &, Adjustment &method) {
    read(table, kAdjustmentFields, method);
}

void read_procedure(StrictTomlTable &file, Protocol &protocol) {
    StrictTomlTable task = file.table("task");
    read(task, kTaskFields, protocol.task);
    task.refuse_unknown_keys();
    StrictTomlTable table = file.table("method");
    read(table, kMethodFields, protocol);
    std::visit([&](auto &method) { read_method(table, protocol.task, method); }, protocol.method);
    table.refuse_unknown_keys();
}

/// The values of a kind of question. Another kind has none of them.
template <typename Fields>
void read_if(QuestionnaireKind kind, StrictTomlTable &table, const Fields &fields,
             QuestionnaireItem &item) {
    const auto name = [](QuestionnaireKind one) {
        return '"' + std::string(kQuestionnaireKindNames[static_cast<std::size_t>(one)]) + '"';
    };
    if (item.kind == kind) {
        read(table, fields, item);
        return;
    }
    for (const Field<QuestionnaireItem> &field : fields) {
        if (table.has_optional(field.name)) {
            table.refuse(field.name, "is there though kind is " + name(item.kind) +
                                         "; it must be left out, as it is of kind " + name(kind) +
                                         " alone");
        }
    }
}

void read_questions(StrictTomlTable &file, std::vector<QuestionnaireItem> &items) {
    if (!file.has_optional("questions")) {
        return;
    }
    file.rows("questions", kMaxRows, [&items](StrictTomlTable &table) {
        QuestionnaireItem item;
        read(table, kQuestionFields, item);
        read_if(QuestionnaireKind::scale, table, kScaleFields, item);
        read_if(QuestionnaireKind::choice, table, kChoiceFields, item);
        table.refuse_unknown_keys();
        refuse_as(table, validate(item));
        check_name(table, item.name, items);
        items.push_back(std::move(item));
    });
}

Protocol protocol_in(StrictTomlTable file) {
    Protocol protocol;
    read(file, kProtocolFields, protocol);
    visit_tables(protocol, [&file](std::string_view name, const auto &fields, auto &values) {
        read_table(file, name, fields, values);
    });
    read_conditions(file, protocol);
    StrictTomlTable variable = file.table("variable");
    read(variable, kVariableFields, protocol.variable);
    variable.refuse_unknown_keys();
    read_procedure(file, protocol);
    read_blocks(file, protocol);
    read_questions(file, protocol.questionnaire);
    file.refuse_unknown_keys();
    refuse_as(file, validate(protocol));
    return protocol;
}

void write_keys(std::ostream &out, std::string_view heading, const Table &keys) {
    out << '\n' << heading << "\n\n";
    write_markdown(out, keys);
}

Table condition_keys() {
    Table table = reference(kConditionFields);
    table.rows.push_back({"`point_m`", "three numbers (the scene's own spot)",
                          "the spot, on the surface, in device coordinates [m]; with `normal`"});
    table.rows.push_back({"`normal`", "three numbers (the scene's own spot)",
                          "out of the surface there; of any length"});
    for (const ParameterFacts &one : condition_parameters()) {
        const std::string_view unit = one.unit == "–" ? std::string_view() : one.unit;
        table.rows.push_back(
            {fmt::format("`{}`", one.name),
             with_unit_and_default(fmt::format("{:g} to {:g}", one.minimum, one.maximum), unit,
                                   toml_number(one.default_value)),
             one.help});
    }
    return table;
}

Table block_keys() {
    Table table = reference(kBlockFields);
    table.rows.push_back(
        {"`conditions`", "names of conditions (required)",
         "whose trials are interleaved in it; without any [[block]] there is one of all"});
    return table;
}

} // namespace

Protocol read_protocol_file(const std::filesystem::path &file) {
    return protocol_in(StrictTomlTable::read(file));
}

Protocol read_protocol_text(const std::string &text, const std::filesystem::path &file) {
    return protocol_in(StrictTomlTable::parse(text, file));
}

void write_protocol_keys(std::ostream &out) {
    write_keys(out, "Before all tables:", reference(kProtocolFields));
    write_keys(out,
               "`[common]`, for all conditions, and `[[condition]]`, for one:", condition_keys());
    write_keys(out, "`[[condition]]` only:", reference(kConditionName));
    write_keys(out, "`[variable]`:", reference(kVariableFields));
    write_keys(out, "`[task]`:", reference(kTaskFields));
    write_keys(out, "`[method]`:", reference(kMethodFields));
    write_keys(out, "`[method]` of the kind constant_stimuli:", reference(kConstantStimuliFields));
    write_keys(out, "`[method]` of the kind staircases:", reference(kStaircaseFields));
    write_keys(out, "`[[method.steps]]` of staircases:", reference(kStepFields));
    write_keys(out, "`[method]` of the kind quest_plus:", reference(kQuestPlusFields));
    write_keys(out,
               "`[method.threshold]`, `[method.slope]`, `[method.guess]` and `[method.lapse]` of "
               "quest_plus, the last two optional:",
               reference(kPriorFields, kPriorAxisFields));
    write_keys(out, "`[method]` of the kind adjustment:", reference(kAdjustmentFields));
    write_keys(out, "`[[block]]`:", block_keys());
    write_keys(out, "`[[questions]]`:", reference(kQuestionFields, kScaleFields, kChoiceFields));
    Protocol any;
    visit_tables(any, [&out](std::string_view name, const auto &fields, const auto &) {
        write_keys(out, fmt::format("`[{}]`:", name), reference(fields));
    });
}

} // namespace springdrive::study
