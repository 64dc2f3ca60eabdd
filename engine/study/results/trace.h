// The course of a method: which levels it presented, and what it thought of the threshold.
#pragma once

#include "engine/study/analysis/direct_estimates.h"
#include "engine/study/results/series.h"

#include <optional>
#include <vector>

namespace springdrive::study {

struct TracePoint {
    int block = 1;
    int trial = 1; ///< of the condition in the block, marked ones too
    int track = 0; ///< of staircases, else 0
    double level = 0.0;
    Outcome outcome;
    bool is_reversal = false; ///< of a staircase
    /// Of QUEST+, after this trial: the mean of the threshold, and a standard deviation of its
    /// posterior on either side.
    std::optional<double> threshold;
    std::optional<double> threshold_low;
    std::optional<double> threshold_high;
};

/// Trials of a block that ended up on another kind of device are not in the series; the method is
/// then not replayed, and the points have levels and answers only.
[[nodiscard]] std::vector<TracePoint> trace_of(const Protocol &protocol, const Series &series);

struct TrackEstimate {
    int block = 1;
    int track = 0;
    ReversalEstimate estimate;
};

/// Of staircases: tracks that turned often enough. Reversals before the last change of the step's
/// size are left out. Empty for other methods.
[[nodiscard]] std::vector<TrackEstimate> reversals_of(const Protocol &protocol,
                                                      const Series &series);

} // namespace springdrive::study
