// The numbers of a protocol's tables: which there are, and their ranges. Files, checks and
// documentation read these lists.
#pragma once

#include "engine/study/protocol/protocol.h"

#include <array>
#include <string_view>

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

inline constexpr std::array<NumberKey<Expectation>, 3> kExpectationKeys{{
    {"threshold", "–", &Expectation::threshold, nullptr, -1e6, 1e6,
     "α, a level; in the variable's unit"},
    {"slope", "–", &Expectation::slope, nullptr, 1e-6, 1e6, "β, per unit of the scale"},
    {"lapse", "–", &Expectation::lapse, nullptr, 0.0, 0.2,
     "λ: wrong answers however strong the stimulus"},
}};

} // namespace springdrive::study
