#include "engine/study/methods/staircases.h"

#include "engine/study/methods/wrong_value.h"

#include <fmt/core.h>

#include <cmath>
#include <limits>

namespace springdrive::study {

namespace {

std::string what_is_wrong_with_steps(const Staircases &method) {
    if (method.steps.empty()) {
        return "steps is empty; it must have at least one";
    }
    const bool ratios = method.scale == Scale::logarithmic;
    for (std::size_t i = 0; i < method.steps.size(); ++i) {
        const StepSize &step = method.steps[i];
        const std::string key = fmt::format("steps[{}]", i);
        const double fewest = i == 0 ? 0.0 : method.steps[i - 1].from_reversal + 1.0;
        if (std::string complaint =
                first_of({unless_from_to(key + ".from_reversal", step.from_reversal, fewest,
                                         i == 0 ? 0.0 : 1000.0),
                          unless_above(key + ".size", step.size, ratios ? 1.0 : 0.0)});
            !complaint.empty()) {
            return complaint;
        }
    }
    return {};
}

} // namespace

std::string what_is_wrong_with(const Staircases &method) {
    constexpr double kMost = std::numeric_limits<double>::max();
    if (std::string complaint = first_of(
            {method.scale == Scale::logarithmic
                 ? unless_above("minimum_level", method.minimum_level, 0.0)
                 : unless_from_to("minimum_level", method.minimum_level, -kMost, kMost),
             unless_above("maximum_level", method.maximum_level, method.minimum_level),
             unless_from_to("correct_for_down", method.correct_for_down, 1, 10),
             unless_from_to("up_to_down", method.up_to_down, 0.01, 100.0),
             unless_from_to("reversals", method.reversals, 0, 1000),
             unless_from_to("trials", method.trials, 1, 10000), what_is_wrong_with_steps(method),
             unless_from_to("start_levels (how many)",
                            static_cast<double>(method.start_levels.size()), 1, 16)});
        !complaint.empty()) {
        return complaint;
    }
    for (const double level : method.start_levels) {
        if (std::string complaint = unless_from_to("start_levels (each)", level,
                                                   method.minimum_level, method.maximum_level);
            !complaint.empty()) {
            return complaint;
        }
    }
    return {};
}

double convergence_proportion(const Staircases &method) {
    return std::pow(method.up_to_down / (1.0 + method.up_to_down), 1.0 / method.correct_for_down);
}

} // namespace springdrive::study
