// The numbers of a protocol's tables: which there are, and their ranges. Files, checks and
// documentation read these lists.
#pragma once

#include "engine/study/methods/wrong_value.h"
#include "engine/study/protocol/protocol.h"

#include <array>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::study {

/// A number of a table, with the default that `Table` gives it.
template <typename Table> struct NumberKey {
    std::string_view key;
    std::string_view unit; ///< "–" where it has none
    double Table::*number = nullptr;
    int Table::*whole = nullptr; ///< instead of `number`
    double minimum = 0.0;        ///< inclusive
    double maximum = 0.0;        ///< inclusive
    std::string_view help;

    [[nodiscard]] double of(const Table &table) const {
        return whole != nullptr ? static_cast<double>(table.*whole) : table.*number;
    }
};

// Before all tables.
inline constexpr std::array<NumberKey<Protocol>, 2> kProtocolKeys{{
    {"seed", "–", nullptr, &Protocol::seed, 0.0, 2'147'483'647.0,
     "of everything that is drawn by chance"},
    {"participants", "–", nullptr, &Protocol::participants, 1.0, 10'000.0,
     "how many are to take part"},
}};

inline constexpr std::array<NumberKey<TrialTiming>, 7> kTimingKeys{{
    {"rest_s", "s", &TrialTiming::rest_s, nullptr, 0.1, 10.0,
     "the hand must be at rest in free space at the spot for so long"},
    {"approach_s", "s", &TrialTiming::approach_s, nullptr, 0.2, 30.0,
     "at most, until the hand is in contact"},
    {"presentation_s", "s", &TrialTiming::presentation_s, nullptr, 0.05, 60.0,
     "of the stimulus in each interval; an adjustment takes so long"},
    {"pause_s", "s", &TrialTiming::pause_s, nullptr, 0.0, 60.0, "between the intervals of a trial"},
    {"response_s", "s", &TrialTiming::response_s, nullptr, 0.5, 600.0,
     "at most, after the last interval; then the trial is marked"},
    {"between_trials_s", "s", &TrialTiming::between_trials_s, nullptr, 0.0, 60.0,
     "from an answer to the next trial"},
    {"expected_response_s", "s", &TrialTiming::expected_response_s, nullptr, 0.1, 600.0,
     "that an answer will take: only the session's length is reckoned with it"},
}};

inline constexpr std::array<NumberKey<Breaks>, 3> kBreakKeys{{
    {"every_trials", "–", nullptr, &Breaks::every_trials, 0.0, 10'000.0,
     "a break within a block after so many trials; 0: none"},
    {"break_s", "s", &Breaks::break_s, nullptr, 0.0, 3600.0,
     "the shortest; the participant may rest longer"},
    {"between_blocks_s", "s", &Breaks::between_blocks_s, nullptr, 0.0, 3600.0,
     "the shortest break between two blocks"},
}};

inline constexpr std::array<NumberKey<Marking>, 5> kMarkingKeys{{
    {"stiffness_percent", "%", &Marking::stiffness_percent, nullptr, 0.1, 100.0,
     "by which the delivered stiffness may differ from the intended one"},
    {"direction_deg", "°", &Marking::direction_deg, nullptr, 0.1, 90.0,
     "by which the delivered force's direction may differ"},
    {"force_percent", "%", &Marking::force_percent, nullptr, 1.0, 100.0,
     "by which the hand's press, or the speed of its blow or stroke, may differ"},
    {"lateness_s", "s", &Marking::lateness_s, nullptr, 0.0, 0.05,
     "of deadlines that the servo missed in a row"},
    {"most_marked", "–", nullptr, &Marking::most_marked, 0.0, 1000.0,
     "marked trials of a block; with the next one it ends unfinished"},
}};

inline constexpr std::array<NumberKey<WindingBand>, 3> kWindingKeys{{
    {"air_C", "°C", &WindingBand::air_C, nullptr, 10.0, 40.0, "air in the room"},
    {"from_C", "°C", &WindingBand::from_C, nullptr, 10.0, 90.0,
     "to which the windings are warmed before the first trial"},
    {"to_C", "°C", &WindingBand::to_C, nullptr, 15.0, 100.0,
     "above which the next trial waits until they have cooled"},
}};

inline constexpr std::array<NumberKey<StoppingRules>, 2> kStoppingKeys{{
    {"longest_session_min", "min", &StoppingRules::longest_session_min, nullptr, 1.0, 480.0,
     "after which the session ends with the present trial"},
    {"most_trips", "–", nullptr, &StoppingRules::most_trips, 0.0, 100.0,
     "of the safety monitor; with the next one the session ends"},
}};

inline constexpr std::array<NumberKey<MaskingNoise>, 1> kNoiseKeys{{
    {"level_dBFS", "dBFS", &MaskingNoise::level_dBFS, nullptr, -80.0, -6.0,
     "RMS of the noise, of the sound output's full scale; the volume makes it comfortable"},
}};

inline constexpr std::array<NumberKey<QuestionnaireItem>, 2> kQuestionKeys{{
    {"lowest", "–", nullptr, &QuestionnaireItem::lowest, -1000.0, 1000.0,
     "scale: its lowest number"},
    {"highest", "–", nullptr, &QuestionnaireItem::highest, -1000.0, 1000.0,
     "scale: its highest number, at most 100 above"},
}};

inline constexpr std::array<NumberKey<FreeSpaceTuning>, 2> kFreeSpaceKeys{{
    {"dR_Ohm", "Ω", &FreeSpaceTuning::dR_Ohm, nullptr,
     control::parameter_of(&control::Tuning::dR_Ohm).minimum,
     control::parameter_of(&control::Tuning::dR_Ohm).maximum,
     "residual winding resistance of all conditions in free space"},
    {"lambda_rad_per_s", "rad/s", &FreeSpaceTuning::lambda_rad_per_s, nullptr,
     control::parameter_of(&control::Tuning::lambda_rad_per_s).minimum,
     control::parameter_of(&control::Tuning::lambda_rad_per_s).maximum,
     "cutoff of the velocity filter in free space, at the first condition's servo rate and delay; "
     "at others the one with the same lag"},
}};

inline constexpr std::array<NumberKey<Task>, 2> kTaskKeys{{
    {"alternatives", "–", nullptr, &Task::alternatives, 2.0, 8.0,
     "intervals, or directions, of a forced choice; 2 otherwise"},
    {"largest_false_alarm_rate", "–", &Task::largest_false_alarm_rate, nullptr, 0.0, 0.5,
     "yes/no: the share of \"yes\" without a stimulus is taken to lie between 0 and this"},
}};

inline constexpr std::array<NumberKey<Practice>, 3> kPracticeKeys{{
    {"fewest_trials", "–", nullptr, &Practice::fewest_trials, 0.0, 1000.0,
     "practice ends after so many once the last `correct_in_a_row` were right"},
    {"correct_in_a_row", "–", nullptr, &Practice::correct_in_a_row, 0.0, 1000.0,
     "0: does not matter"},
    {"most_trials", "–", nullptr, &Practice::most_trials, 0.0, 1000.0,
     "practice ends after so many at the latest; 0: no practice"},
}};

inline constexpr std::array<NumberKey<CatchTrials>, 1> kCatchTrialKeys{{
    {"one_in", "–", nullptr, &CatchTrials::one_in, 0.0, 1000.0,
     "of so many trials one is a catch trial; 0: none"},
}};

// Of [method], by its kind. Levels are in the variable's unit.

inline constexpr double kLargestLevel = kLargestTyped;

inline constexpr std::array<NumberKey<ConstantStimuli>, 2> kConstantStimuliKeys{{
    {"repetitions", "–", nullptr, &ConstantStimuli::repetitions, 1.0, 1000.0,
     "constant_stimuli: of each level in one round"},
    {"blocks", "–", nullptr, &ConstantStimuli::blocks, 1.0, 1000.0,
     "constant_stimuli: rounds through all levels, each in an order by chance"},
}};

inline constexpr std::array<NumberKey<Staircases>, 6> kStaircaseKeys{{
    {"minimum_level", "–", &Staircases::minimum_level, nullptr, -kLargestLevel, kLargestLevel,
     "staircases, adjustment: a step beyond ends here"},
    {"maximum_level", "–", &Staircases::maximum_level, nullptr, -kLargestLevel, kLargestLevel,
     "staircases, adjustment: and here"},
    {"correct_for_down", "–", nullptr, &Staircases::correct_for_down, 1.0, 10.0,
     "staircases: so many right answers in a row lower the level"},
    {"up_to_down", "–", &Staircases::up_to_down, nullptr, 0.01, 100.0,
     "staircases: step up over step down"},
    {"reversals", "–", nullptr, &Staircases::reversals, 0.0, 1000.0,
     "staircases: a track ends after so many; 0: by `trials` alone"},
    {"trials", "–", nullptr, &Staircases::trials, 1.0, 10'000.0,
     "staircases: a track ends after so many at the latest"},
}};

inline constexpr std::array<NumberKey<StepSize>, 2> kStepKeys{{
    {"from_reversal", "–", nullptr, &StepSize::from_reversal, 0.0, 1000.0,
     "this step is in force from so many reversals on"},
    {"size", "–", &StepSize::size, nullptr, 0.0, kLargestLevel,
     "of the step down: a difference of levels, or on a logarithmic scale their ratio"},
}};

inline constexpr std::array<NumberKey<QuestPlus>, 3> kQuestPlusKeys{{
    {"fewest_trials", "–", nullptr, &QuestPlus::fewest_trials, 1.0, 10'000.0,
     "quest_plus: before it may end"},
    {"most_trials", "–", nullptr, &QuestPlus::most_trials, 1.0, 10'000.0,
     "quest_plus: when it ends at the latest"},
    {"threshold_deviation", "–", &QuestPlus::threshold_deviation, nullptr, 0.0, kLargestLevel,
     "quest_plus: ends when the threshold is known to within this standard deviation, on the scale "
     "of its prior; 0: by `most_trials` alone"},
}};

inline constexpr std::array<NumberKey<Prior>, 4> kPriorKeys{{
    {"minimum", "–", &Prior::minimum, nullptr, -kLargestLevel, kLargestLevel,
     "of what is thought possible"},
    {"maximum", "–", &Prior::maximum, nullptr, -kLargestLevel, kLargestLevel,
     "the same as `minimum` if it is known"},
    {"mean", "–", &Prior::mean, nullptr, -kLargestLevel, kLargestLevel,
     "of a normal density before it is cut to the range"},
    {"deviation", "–", &Prior::deviation, nullptr, 0.0, kLargestLevel,
     "of a normal density; on a logarithmic scale that of the logarithm"},
}};

inline constexpr std::array<NumberKey<PriorAxis>, 1> kPriorAxisKeys{{
    {"points", "–", nullptr, &PriorAxis::points, 1.0, 1000.0, "of the grid over the range"},
}};

inline constexpr std::array<NumberKey<Adjustment>, 5> kAdjustmentKeys{{
    {"minimum_level", "–", &Adjustment::minimum_level, nullptr, -kLargestLevel, kLargestLevel,
     "staircases, adjustment: a step beyond ends here"},
    {"maximum_level", "–", &Adjustment::maximum_level, nullptr, -kLargestLevel, kLargestLevel,
     "staircases, adjustment: and here"},
    {"minimum_start", "–", &Adjustment::minimum_start, nullptr, -kLargestLevel, kLargestLevel,
     "adjustment: starts are drawn from here"},
    {"maximum_start", "–", &Adjustment::maximum_start, nullptr, -kLargestLevel, kLargestLevel,
     "adjustment: to here"},
    {"settings", "–", nullptr, &Adjustment::settings, 1.0, 1000.0, "adjustment: how many are made"},
}};

inline constexpr std::array<NumberKey<Expectation>, 3> kExpectationKeys{{
    {"threshold", "–", &Expectation::threshold, nullptr, -kLargestLevel, kLargestLevel,
     "α, a level; in the variable's unit"},
    {"slope", "–", &Expectation::slope, nullptr, kSmallestRatioTyped, kLargestTyped,
     "β, per unit of the scale"},
    {"lapse", "–", &Expectation::lapse, nullptr, 0.0, 0.2,
     "λ: wrong answers however strong the stimulus"},
}};

/// A key of a protocol file, for people.
struct KeyFacts {
    std::string table; ///< "timing"; empty: before all tables
    std::string key;
    std::string unit;          ///< "–" where it has none
    std::string allowed;       ///< "0.1 to 10", "press, blow, pulse or stroke"
    std::string default_value; ///< "required" if it must be there
    std::string help;
};

/// Every key that a protocol file may have, in the order of the manual.
[[nodiscard]] std::vector<KeyFacts> protocol_keys();

/// The same as Markdown tables, one for each table of the file.
void write_protocol_keys(std::ostream &out);

} // namespace springdrive::study
