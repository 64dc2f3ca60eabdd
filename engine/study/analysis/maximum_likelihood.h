// Psychometric functions by maximum likelihood, and whether they describe their trials.
#pragma once

#include "engine/study/methods/psychometric_function.h"
#include "engine/study/methods/random_key.h"

#include <array>
#include <cmath>
#include <span>
#include <vector>

namespace springdrive::study {

struct LevelCount {
    double level = 0.0;
    int positive = 0; ///< correct, or "yes"
    int trials = 0;

    friend bool operator==(const LevelCount &, const LevelCount &) = default;
};

/// By rising level, over all tracks; marked trials are left out.
[[nodiscard]] std::vector<LevelCount> counted(std::span<const PastMethodTrial> trials);

/// k ln ψ + (n − k) ln(1 − ψ), with `possible_proportion`.
[[nodiscard]] inline double likelihood_term(const LevelCount &count, double proportion) {
    const double psi = possible_proportion(proportion);
    return count.positive * std::log(psi) + (count.trials - count.positive) * std::log1p(-psi);
}

/// ln of the probability of the answers in their order, without binomial coefficients.
[[nodiscard]] double log_likelihood(const PsychometricFunction &function,
                                    std::span<const LevelCount> counts);

/// As many trials at each level, answered by the function.
[[nodiscard]] std::vector<LevelCount> simulated_counts(const PsychometricFunction &function,
                                                       std::span<const LevelCount> design,
                                                       RandomKey key);

// Psychometric functions by maximum likelihood, with intervals from the profile of the likelihood.
//
// Threshold and slope are fitted as u(α) and ln β by Fisher's scoring with Levenberg's damping, all
// four parameters within the ranges of their priors, from the best nodes of a coarse grid. An
// interval holds the values whose profile deviance, 2 (max ℓ − max ℓ with the value fixed), is
// below the quantile of χ² with one degree of freedom (Venzon & Moolgavkar 1988, Appl. Stat. 37,
// 87).

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

/// Of the level at which F, without guesses and lapses, has the value `core`. @pre as above; 0 <
/// core < 1
[[nodiscard]] ProfileInterval profile_interval_at(std::span<const LevelCount> counts,
                                                  const FunctionPriors &priors, double core,
                                                  double confidence = 0.95);

// Does a fitted psychometric function describe its trials?
//
// The deviance, D = 2 Σ [k ln(k/(n ψ)) + (n − k) ln((n − k)/(n (1 − ψ)))], is held against the
// deviances of data sets that the fitted function answers at the same levels, each fitted anew
// (Wichmann & Hill 2001, Perception & Psychophysics 63, 1293): with few trials per level it does
// not follow χ². Levels that a method chose by the answers are taken as if they had been fixed.

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
