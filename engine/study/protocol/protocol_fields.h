// The values of a protocol's own tables, as files and the manual have them. Those of tasks and
// methods are in engine/study/methods, of conditions, texts and questions beside these.
#pragma once

#include "base/field.h"
#include "engine/study/protocol/protocol.h"

#include <algorithm>
#include <array>
#include <iosfwd>

namespace springdrive::study {

/// Before all tables.
inline constexpr auto kProtocolFields = std::to_array<Field<Protocol>>({
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

inline constexpr auto kFreeSpaceFields = std::to_array<Field<FreeSpaceTuning>>({
    {"dR_Ohm", &FreeSpaceTuning::dR_Ohm,
     "residual winding resistance of all conditions in free space",
     range_of(&control::Tuning::dR_Ohm), "Ω"},
    {"lambda_rad_per_s", &FreeSpaceTuning::lambda_rad_per_s,
     "cutoff of the velocity filter in free space, at the first condition's servo rate and delay; "
     "at others the one with the same lag",
     range_of(&control::Tuning::lambda_rad_per_s), "rad/s"},
});

/// Of `condition_parameters()`.
inline constexpr auto kParameterNames = [] {
    std::array<std::string_view, control::kParameters.size() + kConditionParameters.size()> names;
    const auto gains =
        std::ranges::transform(control::kParameters, names.begin(), &control::Parameter::name);
    std::ranges::transform(kConditionParameters, gains.out, &Field<Condition>::name);
    return names;
}();

inline constexpr auto kVariableFields = std::to_array<Field<Variable>>({
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
inline constexpr auto kMethodFields = std::to_array<Field<Protocol>>({
    {"kind",
     Choice<Protocol>{kMethodNames,
                      [](const Protocol &protocol) { return protocol.method.index(); },
                      [](Protocol &protocol, std::size_t kind) {
                          protocol.method = std::array<Method, 4>{ConstantStimuli(), Staircases(),
                                                                  QuestPlus(), Adjustment()}[kind];
                      }},
     "which level comes next", kRequired},
});

inline constexpr auto kBlockFields = std::to_array<Field<ProtocolBlock>>({
    {"name", &ProtocolBlock::name, "in results", kRequired},
});

inline constexpr auto kResponseFields = std::to_array<Field<ResponseWays>>({
    {"device", choice_of<&ResponseWays::device>(kResponseDeviceNames), "with which is answered"},
    {"keys", &ResponseWays::keys,
     "one for each alternative; no, yes; or less, more, done of an adjustment", 1.0, 10.0},
});

inline constexpr auto kTimingFields = std::to_array<Field<TrialTiming>>({
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

inline constexpr auto kBreakFields = std::to_array<Field<Breaks>>({
    {"every_trials", &Breaks::every_trials, "a break within a block after so many trials; 0: none",
     0.0, 10'000.0},
    {"break_s", &Breaks::break_s, "the shortest; the participant may rest longer", 0.0, 3600.0,
     "s"},
    {"between_blocks_s", &Breaks::between_blocks_s, "the shortest break between two blocks", 0.0,
     3600.0, "s"},
});

inline constexpr auto kMarkingFields = std::to_array<Field<Marking>>({
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

inline constexpr auto kWindingFields = std::to_array<Field<WindingBand>>({
    {"air_C", &WindingBand::air_C, "air in the room", 10.0, 40.0, "°C"},
    {"from_C", &WindingBand::from_C, "to which the windings are warmed before the first trial",
     10.0, 90.0, "°C"},
    {"to_C", &WindingBand::to_C, "above which the next trial waits until they have cooled", 15.0,
     100.0, "°C"},
});

inline constexpr auto kStoppingFields = std::to_array<Field<StoppingRules>>({
    {"longest_session_min", &StoppingRules::longest_session_min,
     "after which the session ends with the present trial", 1.0, 480.0, "min"},
    {"most_trips", &StoppingRules::max_trips,
     "of the safety monitor; with the next one the session ends", 0.0, 100.0},
});

inline constexpr auto kNoiseFields = std::to_array<Field<MaskingNoise>>({
    {"level_dBFS", &MaskingNoise::level_dBFS,
     "RMS of the noise, of the sound output's full scale; the volume makes it comfortable", -80.0,
     -6.0, "dBFS"},
});

inline constexpr auto kExpectationFields = std::to_array<Field<Expectation>>({
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

/// Every key that a protocol file may have, as Markdown tables in the order of the manual.
void write_protocol_keys(std::ostream &out);

} // namespace springdrive::study
