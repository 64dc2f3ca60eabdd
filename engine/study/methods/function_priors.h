// What is known of a psychometric function before its trials: its family and a prior of each
// parameter. A posterior weighs with the densities; maximum likelihood only keeps to the ranges.
#pragma once

#include "engine/study/methods/prior.h"
#include "engine/study/methods/psychometric_function.h"
#include "engine/study/methods/random_key.h"
#include "engine/study/methods/task.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>

namespace springdrive::study {

/// In this order wherever parameters are numbered.
enum class FunctionParameter : std::uint8_t { threshold, slope, guess, lapse };

struct FunctionPriors {
    FunctionFamily family;
    Prior threshold;
    Prior slope;
    Prior guess;
    Prior lapse;

    friend bool operator==(const FunctionPriors &, const FunctionPriors &) = default;
};

/// Empty if the priors can be used; else the first bad key, with value and range.
[[nodiscard]] std::string validate(const FunctionPriors &priors);

/// Priors that let the trials speak: with W the span of the levels on the scale, the threshold is
/// uniform on the scale from W/2 below the lowest level to W/2 above the highest one, the slope
/// log-uniform from 0.5/W to 50/W, the lapse rate uniform from 0 to 0.1, the guess rate as the task
/// says. A level 0 on a logarithmic scale is left out of the span.
/// @pre at least two different levels
[[nodiscard]] FunctionPriors usual_priors(FunctionFamily family, const Task &task,
                                          std::span<const double> levels);

/// A function drawn from the priors.
[[nodiscard]] PsychometricFunction drawn_function(const FunctionPriors &priors, RandomKey key);

/// F of an observer who guesses but does not lapse, from the proportion of positive answers:
/// (p − γ)/(1 − γ). So 75 % correct of two alternatives is F = 0.5.
[[nodiscard]] inline double core_without_lapses(double proportion, double guess) {
    return (proportion - guess) / (1.0 - guess);
}

} // namespace springdrive::study
