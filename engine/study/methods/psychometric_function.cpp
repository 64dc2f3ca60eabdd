#include "engine/study/methods/psychometric_function.h"

#include "base/assertions.h"
#include "base/bisection.h"

#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace springdrive::study {

std::string unless_level(std::string_view key, double value, Scale scale) {
    return unless_from_to(key, value, scale == Scale::logarithmic ? kMinRatioTyped : -kMaxTyped,
                          kMaxTyped);
}

std::string unless_above(std::string_view key, double value, double minimum) {
    return value > minimum && std::isfinite(value)
               ? std::string()
               : fmt::format("{} is {:g}; it must be a finite number above {:g}", key, value,
                             minimum);
}

std::string unless_finite(std::string_view key, std::span<const double> values) {
    for (const double value : values) {
        if (!std::isfinite(value)) {
            return fmt::format("{} has {:g}; each must be a number", key, value);
        }
    }
    return {};
}

std::string unless_rising(std::string_view key, std::span<const double> levels,
                          std::size_t fewest) {
    if (levels.size() < fewest) {
        return fmt::format("{} has {} levels; it must have at least {}", key, levels.size(),
                           fewest);
    }
    if (std::string error = unless_finite(key, levels); !error.empty()) {
        return error;
    }
    for (std::size_t i = 1; i < levels.size(); ++i) {
        if (levels[i] <= levels[i - 1]) {
            return fmt::format("{} has {:g} after {:g}; each must be above the one before", key,
                               levels[i], levels[i - 1]);
        }
    }
    return {};
}

std::string first_of(std::initializer_list<std::string> errors) {
    for (const std::string &error : errors) {
        if (!error.empty()) {
            return error;
        }
    }
    return {};
}

namespace {

/// Φ(z), exact in both tails.
double normal_proportion(double z) { return 0.5 * std::erfc(-z * std::numbers::sqrt2 / 2.0); }

/// Φ⁻¹, by bisection to the last bits: it is not called often.
double normal_argument(double proportion) {
    constexpr double kFar = 40.0; // Φ(−40) is below the least double
    constexpr int kHalvings = 80;
    return bisect({-kFar, kFar}, kHalvings,
                  [&](double z) { return normal_proportion(z) < proportion; })
        .holds_at;
}

/// Of a normal density, F at u.
double normal_below(const Prior &prior, double u) {
    return core_proportion(Shape::cumulative_normal,
                           (u - on_scale(prior.scale, prior.mean)) / prior.deviation);
}

} // namespace

std::string validate(const PsychometricFunction &function) {
    return first_of({unless_level("threshold", function.threshold, function.family.scale),
                     unless_level("slope", function.slope, Scale::logarithmic),
                     unless_from_to("guess", function.guess, 0.0, 1.0),
                     unless_from_to("lapse", function.lapse, 0.0, 1.0 - function.guess)});
}

double core_proportion(Shape shape, double z) {
    switch (shape) {
    case Shape::cumulative_normal:
        return normal_proportion(z);
    case Shape::logistic:
        return 1.0 / (1.0 + std::exp(-z));
    case Shape::weibull:
        break;
    }
    return -std::expm1(-std::exp(z));
}

double core_argument(Shape shape, double proportion) {
    SPRINGDRIVE_ASSERT(proportion > 0.0 && proportion < 1.0);
    switch (shape) {
    case Shape::cumulative_normal:
        return normal_argument(proportion);
    case Shape::logistic:
        return std::log(proportion) - std::log1p(-proportion);
    case Shape::weibull:
        break;
    }
    return std::log(-std::log1p(-proportion));
}

double core_density(Shape shape, double z) {
    switch (shape) {
    case Shape::cumulative_normal:
        return std::exp(-0.5 * z * z) * std::numbers::inv_sqrtpi / std::numbers::sqrt2;
    case Shape::logistic: {
        const double tail = std::exp(-std::abs(z)); // even in z, and does not overflow
        return tail / ((1.0 + tail) * (1.0 + tail));
    }
    case Shape::weibull:
        break;
    }
    return z > 700.0 ? 0.0 : std::exp(z - std::exp(z)); // e^z would overflow
}

double core_at_threshold(Shape shape) { return core_proportion(shape, 0.0); }

double proportion_at(const PsychometricFunction &function, double level) {
    const Scale scale = function.family.scale;
    const double z =
        function.slope * (on_scale(scale, level) - on_scale(scale, function.threshold));
    return function.guess +
           (1.0 - function.guess - function.lapse) * core_proportion(function.family.shape, z);
}

double level_at_core(const PsychometricFunction &function, double core) {
    const Scale scale = function.family.scale;
    return level_from(scale, on_scale(scale, function.threshold) +
                                 core_argument(function.family.shape, core) / function.slope);
}

std::optional<double> level_at(const PsychometricFunction &function, double proportion) {
    const double core = (proportion - function.guess) / (1.0 - function.guess - function.lapse);
    return core > 0.0 && core < 1.0 ? std::optional(level_at_core(function, core)) : std::nullopt;
}

Prior known(double value) {
    Prior prior;
    prior.minimum = prior.maximum = prior.mean = value;
    return prior;
}

std::string validate(const Prior &prior, std::string_view name) {
    const auto key = [&](std::string_view member) { return fmt::format("{}.{}", name, member); };
    const bool ratios = prior.scale == Scale::logarithmic;
    constexpr double kMax = std::numeric_limits<double>::max();
    const std::string range =
        first_of({ratios ? unless_above(key("minimum"), prior.minimum, 0.0)
                         : unless_from_to(key("minimum"), prior.minimum, -kMax, kMax),
                  unless_from_to(key("maximum"), prior.maximum, prior.minimum, kMax)});
    if (!range.empty() || prior.density == Density::uniform) {
        return range;
    }
    return first_of({unless_from_to(key("mean"), prior.mean, prior.minimum, prior.maximum),
                     unless_above(key("deviation"), prior.deviation, 0.0)});
}

PriorGrid grid_of(const Prior &prior, int points) {
    SPRINGDRIVE_ASSERT(points >= 1);
    if (prior.minimum == prior.maximum) {
        return {{prior.minimum}, {1.0}};
    }
    const double first = on_scale(prior.scale, prior.minimum);
    const double width = (on_scale(prior.scale, prior.maximum) - first) / points;
    PriorGrid grid;
    double sum = 0.0;
    for (int i = 0; i < points; ++i) {
        const double u = first + (i + 0.5) * width;
        const double z = (u - on_scale(prior.scale, prior.mean)) / prior.deviation;
        grid.values.push_back(level_from(prior.scale, u));
        grid.weights.push_back(prior.density == Density::uniform ? 1.0 : std::exp(-0.5 * z * z));
        sum += grid.weights.back();
    }
    for (double &weight : grid.weights) {
        weight /= sum;
    }
    return grid;
}

double quantile(const Prior &prior, double share) {
    SPRINGDRIVE_ASSERT(share >= 0.0 && share <= 1.0);
    const double first = on_scale(prior.scale, prior.minimum);
    const double last = on_scale(prior.scale, prior.maximum);
    if (prior.density == Density::uniform || first == last) {
        return level_from(prior.scale, first + share * (last - first));
    }
    const double below_first = normal_below(prior, first);
    const double below = below_first + share * (normal_below(prior, last) - below_first);
    const double z = below <= 0.0   ? -std::numeric_limits<double>::infinity()
                     : below >= 1.0 ? std::numeric_limits<double>::infinity()
                                    : core_argument(Shape::cumulative_normal, below);
    return level_from(
        prior.scale,
        std::clamp(on_scale(prior.scale, prior.mean) + z * prior.deviation, first, last));
}

std::string validate(const FunctionPriors &priors) {
    const std::string error =
        first_of({validate(priors.threshold, "threshold"), validate(priors.slope, "slope"),
                  validate(priors.guess, "guess"), validate(priors.lapse, "lapse")});
    if (!error.empty()) {
        return error;
    }
    return first_of(
        {priors.family.scale == Scale::logarithmic
             ? unless_above("threshold.minimum", priors.threshold.minimum, 0.0)
             : std::string(),
         unless_above("slope.minimum", priors.slope.minimum, 0.0),
         unless_from_to("guess.minimum", priors.guess.minimum, 0.0, 1.0),
         unless_from_to("guess.maximum", priors.guess.maximum, 0.0, 1.0),
         unless_from_to("lapse.minimum", priors.lapse.minimum, 0.0, 1.0),
         unless_from_to("lapse.maximum", priors.lapse.maximum, 0.0, 1.0 - priors.guess.maximum)});
}

FunctionPriors usual_priors(FunctionFamily family, const Task &task,
                            std::span<const double> levels) {
    double lowest = std::numeric_limits<double>::max();
    double highest = -lowest;
    for (const double level : levels) {
        if (family.scale == Scale::linear || level > 0.0) {
            lowest = std::min(lowest, on_scale(family.scale, level));
            highest = std::max(highest, on_scale(family.scale, level));
        }
    }
    SPRINGDRIVE_ASSERT(highest > lowest);
    const double span = highest - lowest;
    FunctionPriors priors;
    priors.family = family;
    priors.threshold.scale = family.scale;
    priors.threshold.minimum = level_from(family.scale, lowest - 0.5 * span);
    priors.threshold.maximum = level_from(family.scale, highest + 0.5 * span);
    priors.slope.scale = Scale::logarithmic;
    priors.slope.minimum = 0.5 / span;
    priors.slope.maximum = 50.0 / span;
    const GuessRange guess = guess_range(task);
    priors.guess.minimum = guess.minimum;
    priors.guess.maximum = guess.maximum;
    priors.lapse.minimum = 0.0;
    priors.lapse.maximum = 0.1;
    return priors;
}

PsychometricFunction drawn_function(const FunctionPriors &priors, RandomKey key) {
    return {priors.family, quantile(priors.threshold, uniform(child(key, 0))),
            quantile(priors.slope, uniform(child(key, 1))),
            quantile(priors.guess, uniform(child(key, 2))),
            quantile(priors.lapse, uniform(child(key, 3)))};
}

} // namespace springdrive::study
