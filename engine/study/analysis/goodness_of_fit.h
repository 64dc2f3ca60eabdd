// Does a fitted psychometric function describe its trials?
//
// The deviance, D = 2 Σ [k ln(k/(n ψ)) + (n − k) ln((n − k)/(n (1 − ψ)))], is held against the
// deviances of data sets that the fitted function answers at the same levels, each fitted anew
// (Wichmann & Hill 2001, Perception & Psychophysics 63, 1293): with few trials per level it does
// not follow χ². Levels that a method chose by the answers are taken as if they had been fixed.
#pragma once

#include "engine/study/analysis/level_counts.h"
#include "engine/study/analysis/maximum_likelihood.h"
#include "engine/study/methods/random_key.h"

#include <span>

namespace springdrive::study {

[[nodiscard]] double deviance(const PsychometricFunction &function,
                              std::span<const LevelCount> counts);

struct GoodnessOfFit {
    double deviance = 0.0;
    /// The share of simulated data sets whose deviance is as large, counting the data themselves:
    /// below 0.05 the function does not describe the trials.
    double p_value = 1.0;
    /// Pearson's X² over its degrees of freedom, levels less free parameters (McCullagh & Nelder
    /// 1989, section 4.5): above 1 the answers scatter more than independent trials do, and the
    /// intervals are too narrow by its root. 0 without degrees of freedom.
    double dispersion = 0.0;
    int degrees_of_freedom = 0;
};

/// @pre the fit is one of `counts` with `priors`; simulated >= 1
[[nodiscard]] GoodnessOfFit goodness_of_fit(const LikelihoodFit &fit,
                                            std::span<const LevelCount> counts,
                                            const FunctionPriors &priors, RandomKey key,
                                            int simulated = 400);

} // namespace springdrive::study
