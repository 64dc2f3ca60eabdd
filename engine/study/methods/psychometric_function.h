// The psychometric function: the probability of a correct answer, or of "yes", over the level x of
// the stimulus,
//
//   ψ(x) = γ + (1 − γ − λ) F(z),   z = β (u(x) − u(α)),
//
// with α the threshold, β the slope, γ the guess rate and λ the lapse rate (Wichmann & Hill 2001,
// Perception & Psychophysics 63, eq. (1)); u is the scale, x or ln x. It rises with the level.
//
//   shape              F(z)              F at the threshold   on a logarithmic scale
//   cumulative_normal  Φ(z)              0.5                  β = 1/σ of ln x
//   logistic           1/(1 + e^(−z))    0.5                  F = 1/(1 + (α/x)^β)
//   weibull            1 − exp(−e^z)     1 − 1/e = 0.632      F = 1 − exp(−(x/α)^β), Weibull's
//
// On a linear scale β has the unit 1/level, on a logarithmic one it has none; `weibull` on a linear
// scale is Gumbel's distribution. Fechner's σ of a cumulative normal is 1/β.
#pragma once

#include "engine/study/methods/scale.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace springdrive::study {

enum class Shape : std::uint8_t { cumulative_normal, logistic, weibull };

/// By the number of the shape, as in protocol files.
inline constexpr std::array<std::string_view, 3> kShapeNames{"cumulative_normal", "logistic",
                                                             "weibull"};

struct FunctionFamily {
    Shape shape = Shape::weibull;
    Scale scale = Scale::logarithmic;

    friend bool operator==(const FunctionFamily &, const FunctionFamily &) = default;
};

struct PsychometricFunction {
    FunctionFamily family;
    double threshold = 1.0; ///< α, a level
    double slope = 3.5;     ///< β > 0, per unit of the scale
    double guess = 0.5;     ///< γ: chance in forced choice, false alarms in yes/no
    double lapse = 0.02;    ///< λ: wrong answers however strong the stimulus

    friend bool operator==(const PsychometricFunction &, const PsychometricFunction &) = default;
};

/// Empty if the function can be evaluated; else its first bad parameter, with value and range.
[[nodiscard]] std::string validate(const PsychometricFunction &function);

/// F(z): without guesses and lapses.
[[nodiscard]] double core_proportion(Shape shape, double z);

/// The inverse of `core_proportion`. @pre 0 < proportion < 1
[[nodiscard]] double core_argument(Shape shape, double proportion);

/// dF/dz.
[[nodiscard]] double core_density(Shape shape, double z);

/// F at the threshold, where z = 0.
[[nodiscard]] double core_at_threshold(Shape shape);

/// ψ at a level. On a logarithmic scale, level 0 (no stimulus) gives γ.
[[nodiscard]] double proportion_at(const PsychometricFunction &function, double level);

/// Keeps ψ off 0 and 1 where its logarithm is taken: an answer that a function does not allow is
/// then only very unlikely.
inline constexpr double kMinProportion = 1e-12;
[[nodiscard]] inline double possible_proportion(double proportion) {
    return std::clamp(proportion, kMinProportion, 1.0 - kMinProportion);
}

/// The level at which F, without guesses and lapses, has that value. @pre 0 < core < 1
[[nodiscard]] double level_at_core(const PsychometricFunction &function, double core);

/// The level at which ψ itself has that value; nothing unless γ < proportion < 1 − λ.
[[nodiscard]] std::optional<double> level_at(const PsychometricFunction &function,
                                             double proportion);

} // namespace springdrive::study
