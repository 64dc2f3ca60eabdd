#include "engine/study/methods/function_priors.h"

#include "base/assertions.h"
#include "engine/study/methods/wrong_value.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace springdrive::study {

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
