#include "engine/study/methods/psychometric_function.h"

#include "base/assertions.h"
#include "base/bisection.h"
#include "engine/study/methods/wrong_value.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace springdrive::study {

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

} // namespace springdrive::study
