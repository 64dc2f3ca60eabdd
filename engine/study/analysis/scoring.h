// Maximises the likelihood of a psychometric function, some parameters of which may be held.
#pragma once

#include "engine/study/analysis/level_counts.h"
#include "engine/study/methods/function_priors.h"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <span>

namespace springdrive::study {

/// What is maximised over: u of the level at which F is `core`, ln β, γ, λ.
using Coordinates = Eigen::Vector4d;

struct ScoredModel {
    FunctionFamily family;
    double core_argument = 0.0; ///< z where F is `core`; 0 at the threshold itself
    Coordinates lowest;
    Coordinates highest;
};

struct Scored {
    Coordinates at;
    double log_likelihood = 0.0;
};

/// @param core  which proportion of F the first coordinate is the level of. The range of its level
///              is that of the threshold, wider by what the flattest slope puts between both.
[[nodiscard]] ScoredModel model_at(const FunctionPriors &priors, double core);

/// The parameters in their own units.
[[nodiscard]] PsychometricFunction function_at(const ScoredModel &model, const Coordinates &at);

/// The maximum that is reached uphill from `start`, moved into the ranges.
/// @param held  coordinates that stay as they are
[[nodiscard]] Scored scored_from(std::span<const LevelCount> counts, const ScoredModel &model,
                                 const Coordinates &start, const std::array<bool, 4> &held = {});

/// The best of those from the most likely nodes of a coarse grid over the ranges.
[[nodiscard]] Scored scored_best(std::span<const LevelCount> counts, const ScoredModel &model,
                                 const std::array<bool, 4> &held = {},
                                 const Coordinates &held_at = Coordinates::Zero());

} // namespace springdrive::study
