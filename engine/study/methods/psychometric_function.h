// What a participant is asked, on which scale of levels, with the lines in which a specification is
// refused; and the psychometric function of the answers.
#pragma once

#include "base/field.h"
#include "engine/study/methods/random_key.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::study {

enum class Scale : std::uint8_t {
    linear,      ///< differences count: u = x
    logarithmic, ///< ratios count: u = ln x, so levels are above 0
};

/// By the number of the scale, as in protocol files.
inline constexpr std::array<std::string_view, 2> kScaleNames{"linear", "logarithmic"};

/// Levels and slopes that people type: what lies beyond is a slip of the keyboard in every unit
/// that a protocol has.
inline constexpr double kMaxTyped = 1e6;
inline constexpr double kMinRatioTyped = 1e-6; ///< of what must be above 0
inline constexpr NumberRange kTypedLevel{-kMaxTyped, kMaxTyped};

/// u(x). @pre level > 0 on a logarithmic scale
[[nodiscard]] inline double on_scale(Scale scale, double level) {
    return scale == Scale::linear ? level : std::log(level);
}

/// x(u), the inverse of `on_scale`.
[[nodiscard]] inline double level_from(Scale scale, double on_scale) {
    return scale == Scale::linear ? on_scale : std::exp(on_scale);
}

// The lines in which a specification is refused: key, value and range.

/// "KEY is VALUE; it must be from …" unless it can be a typed level: within `kMaxTyped`, and on
/// a logarithmic scale not below `kMinRatioTyped`.
[[nodiscard]] std::string unless_level(std::string_view key, double value, Scale scale);

/// "KEY is VALUE; it must be a finite number above MINIMUM" if it is not, or not finite; else
/// empty.
[[nodiscard]] std::string unless_above(std::string_view key, double value, double minimum);

/// Refuses levels that are fewer than `fewest`, not finite or not rising; else empty.
[[nodiscard]] std::string unless_rising(std::string_view key, std::span<const double> levels,
                                        std::size_t fewest);

/// Refuses values that are not finite; else empty.
[[nodiscard]] std::string unless_finite(std::string_view key, std::span<const double> values);

/// The first that is not empty.
[[nodiscard]] std::string first_of(std::initializer_list<std::string> errors);

// What a participant is asked to do in each trial.

enum class TaskKind : std::uint8_t {
    forced_choice_by_interval, ///< in which of m intervals of time was the stimulus
    forced_choice_by_place,    ///< at which of m places, or in which of m directions, was it
    yes_no,                    ///< was it there, was it stronger than the standard
    adjustment,                ///< set the level yourself
};

/// By the number of the kind, as in protocol files.
inline constexpr std::array<std::string_view, 4> kTaskKindNames{
    "forced_choice_by_interval", "forced_choice_by_place", "yes_no", "adjustment"};

struct Task {
    TaskKind kind = TaskKind::forced_choice_by_interval;
    int alternatives = 2; ///< m of forced choice, 2 to 8; 2 for the other kinds
    /// Of yes/no: the share of "yes" without a stimulus is not known; it is taken to lie between 0
    /// and this, all values being equally likely before the study. 0: no false alarms.
    double largest_false_alarm_rate = 0.5;

    friend bool operator==(const Task &, const Task &) = default;
};

inline constexpr auto kTaskFields = std::to_array<Field<Task>>({
    {"kind", choice_of<&Task::kind>(kTaskKindNames), "what is asked in a trial", kRequired},
    {"alternatives", &Task::alternatives,
     "intervals, or directions, of a forced choice; 2 otherwise", 2.0, 8.0},
    {"largest_false_alarm_rate", &Task::largest_false_alarm_rate,
     "yes/no: the share of \"yes\" without a stimulus is taken to lie between 0 and this", 0.0,
     0.5},
});

/// Empty if the task can be used; else the first bad key, with value and range.
[[nodiscard]] std::string validate(const Task &task);

[[nodiscard]] constexpr bool is_forced_choice(TaskKind kind) {
    return kind == TaskKind::forced_choice_by_interval || kind == TaskKind::forced_choice_by_place;
}

/// Known bounds of the guess rate γ: 1/m of forced choice, 0 to the largest rate of yes/no.
struct GuessRange {
    double minimum = 0.0;
    double maximum = 0.0;
};
[[nodiscard]] GuessRange guess_range(const Task &task);

// A trial as a method sees it: what it asked for, and what came of it.

/// What is to be presented.
struct MethodTrial {
    double level = 0.0; ///< of an adjustment: where it starts
    int track = 0;      ///< of staircases, else 0

    friend bool operator==(const MethodTrial &, const MethodTrial &) = default;
};

/// What came of a trial.
struct Outcome {
    bool positive = false; ///< correct, or "yes"
    double setting = 0.0;  ///< of an adjustment
    /// The trial did not happen: it tells the method nothing, and is presented again. Constant
    /// stimuli put its level back at a drawn place among those that are left in its block, not the
    /// next one if others are left; an adaptive method asks for the same level when the track has
    /// its next turn; an adjustment starts from the same level again.
    bool marked = false;

    friend bool operator==(const Outcome &, const Outcome &) = default;
};

/// A trial that was run.
struct PastMethodTrial {
    MethodTrial presented;
    Outcome outcome;

    friend bool operator==(const PastMethodTrial &, const PastMethodTrial &) = default;
};

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

// What is known about one parameter of a psychometric function before a study: a density over a
// range, and the grid on which it is evaluated.

enum class Density : std::uint8_t { uniform, normal };

/// By the number of the density, as in protocol files.
inline constexpr std::array<std::string_view, 2> kDensityNames{"uniform", "normal"};

/// The density is one of u(value), on the scale: uniform on a logarithmic scale means that equal
/// ratios are equally likely. It is 0 outside the range, which a normal density is cut to.
struct Prior {
    Scale scale = Scale::linear;
    double minimum = 0.0;
    double maximum = 1.0; ///< equal to `minimum` if the value is known
    Density density = Density::uniform;
    double mean = 0.5;      ///< of a normal density before it is cut: a value, not its logarithm
    double deviation = 1.0; ///< of a normal density: on the scale, so of ln(value) on a logarithmic

    friend bool operator==(const Prior &, const Prior &) = default;
};

inline constexpr auto kPriorFields = std::to_array<Field<Prior>>({
    {"scale", choice_of<&Prior::scale>(kScaleNames),
     "on which the density is one; without it the method's, of the slope logarithmic", kDerived},
    {"density", choice_of<&Prior::density>(kDensityNames), "of what is thought likely"},
    {"minimum", &Prior::minimum,
     "of what is thought possible; without it 0, of guess the task's, of lapse 0.02", kTypedLevel,
     "", kDerived},
    {"maximum", &Prior::maximum,
     "the same as `minimum` if it is known; without it 1, of guess and lapse as there", kTypedLevel,
     "", kDerived},
    {"mean", &Prior::mean, "of a normal density before it is cut to the range", kTypedLevel},
    {"deviation", &Prior::deviation,
     "of a normal density; on a logarithmic scale that of the logarithm", 0.0, kMaxTyped},
});

/// The prior of a value that is known.
[[nodiscard]] Prior known(double value);

/// Empty if the prior can be used; else "NAME.KEY is VALUE; it must be …".
[[nodiscard]] std::string validate(const Prior &prior, std::string_view name);

/// Nodes of the midpoint rule: the range is cut into cells of equal width on the scale, and each
/// node stands for its cell.
struct PriorGrid {
    std::vector<double> values;  ///< the middles of the cells
    std::vector<double> weights; ///< of the cells, sum 1
};

/// @pre points >= 1. A known value has one node, whatever `points` is.
[[nodiscard]] PriorGrid grid_of(const Prior &prior, int points);

/// The value below which the prior has that share of its weight. @pre 0 <= share <= 1
[[nodiscard]] double quantile(const Prior &prior, double share);

// What is known of a psychometric function before its trials: its family and a prior of each
// parameter. A posterior weighs with the densities; maximum likelihood only keeps to the ranges.

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

} // namespace springdrive::study
