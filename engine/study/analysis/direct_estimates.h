// Thresholds without a fit: the mean of a staircase's reversals, the mean of settings.
#pragma once

#include "engine/study/analysis/student.h"
#include "engine/study/methods/adjustment.h"
#include "engine/study/methods/staircases.h"
#include "engine/study/methods/trial.h"

#include <optional>
#include <span>
#include <vector>

namespace springdrive::study {

/// Of one track. The level belongs to the method's `convergence_proportion`, to within the bias
/// that its steps leave (staircases.h).
struct ReversalEstimate {
    double level = 0.0;              ///< the mean, on the scale, of the levels at reversals
    double deviation_on_scale = 0.0; ///< of these levels
    int reversals = 0;               ///< averaged
};

/// The first `left_out` reversals of each track are left out, and one more if the rest is odd, so
/// that there are as many peaks as valleys (Levitt 1971). Nothing for a track with less than two
/// left.
[[nodiscard]] std::vector<std::optional<ReversalEstimate>>
reversal_estimates(const Staircases &method, std::span<const PastMethodTrial> trials, int left_out);

/// Of the settings of an adjustment, all on its scale; nothing without any. Marked trials are left
/// out.
[[nodiscard]] std::optional<MeanSummary> settings_on_scale(const Adjustment &method,
                                                           std::span<const PastMethodTrial> trials,
                                                           double confidence = 0.95);

/// Weber's fraction of a just noticeable difference, (threshold − standard)/standard, from the
/// level of the comparison at threshold. @pre standard > 0
[[nodiscard]] inline double weber_fraction(double threshold, double standard) {
    return (threshold - standard) / standard;
}

} // namespace springdrive::study
