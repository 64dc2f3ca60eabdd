// QUEST+ (Watson 2017, Journal of Vision 17(3):10): each trial is presented at the level that
// leaves the least entropy to be expected of the posterior over threshold, slope, guess and lapse.
#pragma once

#include "engine/study/methods/prior.h"
#include "engine/study/methods/psychometric_function.h"

#include <string>
#include <vector>

namespace springdrive::study {

/// A prior, and the number of nodes of its grid.
struct PriorAxis {
    Prior prior;
    int points = 1;

    friend bool operator==(const PriorAxis &, const PriorAxis &) = default;
};

struct QuestPlus {
    FunctionFamily family;
    std::vector<double> levels; ///< that may be presented, rising
    PriorAxis threshold;
    PriorAxis slope;
    PriorAxis guess; ///< known in forced choice: known(1/m)
    PriorAxis lapse;
    int fewest_trials = 20;
    int most_trials = 60;
    /// Ends, from `fewest_trials` on, when the posterior's standard deviation of the threshold, on
    /// the scale of its prior, is not above this; 0: by `most_trials` alone.
    double threshold_deviation = 0.0;

    friend bool operator==(const QuestPlus &, const QuestPlus &) = default;
};

/// Levels times nodes of all four grids: above it, the next level would take too long.
inline constexpr double kLargestQuestTable = 20e6;

/// Empty if the method can be used; else the first bad key, with value and range.
[[nodiscard]] std::string what_is_wrong_with(const QuestPlus &method);

} // namespace springdrive::study
