// What the trials of one participant in one condition say.
#pragma once

#include "engine/study/analysis/goodness_of_fit.h"
#include "engine/study/analysis/maximum_likelihood.h"
#include "engine/study/analysis/posterior.h"
#include "engine/study/results/trace.h"

#include <optional>
#include <vector>

namespace springdrive::study {

/// A point of the fitted functions, for drawing.
struct FunctionPoint {
    double level = 0.0;
    double proportion = 0.0; ///< of positive answers, by `FittedFunction::function`
    double low = 0.0; ///< of the posterior's interval of F there, with its guesses and lapses
    double high = 0.0;
    double likelihood_proportion = 0.0; ///< by maximum likelihood
};

/// A psychometric function, by both ways of docs/study_methods.md; intervals hold 95 %.
struct FittedFunction {
    PosteriorSummary threshold;
    PosteriorSummary slope;
    PosteriorSummary lapse;
    PosteriorSummary guess;
    PsychometricFunction function;     ///< with the posterior's medians
    std::vector<FunctionPoint> course; ///< over all levels that can be presented, and a tenth more
    LikelihoodFit likelihood;
    ProfileInterval likelihood_threshold;
    ProfileInterval likelihood_slope;
    GoodnessOfFit goodness;
};

/// The mean of settings, as levels: on a logarithmic scale the geometric mean.
struct SettingsResult {
    double mean = 0.0;
    double low = 0.0; ///< of Student's interval; −∞ (0) and ∞ of a single setting
    double high = 0.0;
    double standard_error_on_scale = 0.0;
    double deviation_on_scale = 0.0;
};

struct SeriesResult {
    Series series;
    int trials = 0; ///< that count
    int marked = 0;
    std::vector<LevelCount> counts;         ///< empty of an adjustment
    std::optional<FittedFunction> fitted;   ///< nothing of an adjustment, and without trials
    std::optional<SettingsResult> settings; ///< of an adjustment
    /// Of a forced choice against a standard: see `weber_fraction_of`.
    std::optional<double> weber_fraction;
    std::optional<double> median_response_s;
    std::vector<TracePoint> trace;
    std::vector<TrackEstimate> reversals;
};

/// Deterministic; a tenth of a second or so, most of it for the goodness of fit.
/// @pre validate(protocol) is empty
[[nodiscard]] SeriesResult result_of(const Protocol &protocol, Series series);

/// |comparison at threshold − standard|/standard of the parameter under test; of η the fraction of
/// 1 − η, to which the stiffness is proportional. Nothing where the standard is 0, where the
/// standard is another condition, and in tasks that are no forced choice: their threshold is where
/// both are equal, no difference that is just felt.
[[nodiscard]] std::optional<double> weber_fraction_of(const Protocol &protocol, double threshold);

} // namespace springdrive::study
