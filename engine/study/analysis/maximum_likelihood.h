// Psychometric functions by maximum likelihood, with intervals from the profile of the likelihood.
//
// Threshold and slope are fitted as u(α) and ln β by Fisher's scoring with Levenberg's damping, all
// four parameters within the ranges of their priors, from the best nodes of a coarse grid. An
// interval holds the values whose profile deviance, 2 (max ℓ − max ℓ with the value fixed), is
// below the quantile of χ² with one degree of freedom (Venzon & Moolgavkar 1988, Appl. Stat. 37,
// 87).
#pragma once

#include "engine/study/analysis/level_counts.h"
#include "engine/study/methods/function_priors.h"

#include <array>
#include <span>

namespace springdrive::study {

/// Of a fitted parameter, in its unit. An open end is the end of its range, which the trials do not
/// exclude.
struct ProfileInterval {
    double low = 0.0;
    double high = 0.0;
    bool is_low_open = false;
    bool is_high_open = false;
};

struct LikelihoodFit {
    PsychometricFunction function;
    double log_likelihood = 0.0;
    int free_parameters = 0; ///< whose range is no single value
    /// By the number of the parameter: it lies at an end of its range, so the trials do not tell
    /// it.
    std::array<bool, 4> is_at_end{};
};

/// @pre validate(priors) is empty; at least one trial
[[nodiscard]] LikelihoodFit maximum_likelihood(std::span<const LevelCount> counts,
                                               const FunctionPriors &priors);

/// @pre as above; 0 < confidence < 1
[[nodiscard]] ProfileInterval profile_interval(std::span<const LevelCount> counts,
                                               const FunctionPriors &priors,
                                               FunctionParameter parameter,
                                               double confidence = 0.95);

/// Of the level at which F, without guesses and lapses, has the value `core`; see
/// `core_without_lapses`. @pre as above; 0 < core < 1
[[nodiscard]] ProfileInterval profile_interval_at(std::span<const LevelCount> counts,
                                                  const FunctionPriors &priors, double core,
                                                  double confidence = 0.95);

} // namespace springdrive::study
