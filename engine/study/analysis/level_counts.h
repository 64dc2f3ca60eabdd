// What a fit needs of a series of trials: how many answers were positive at each level.
#pragma once

#include "engine/study/methods/psychometric_function.h"
#include "engine/study/methods/random_key.h"
#include "engine/study/methods/trial.h"

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

} // namespace springdrive::study
