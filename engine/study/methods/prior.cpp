#include "engine/study/methods/prior.h"

#include "base/assertions.h"
#include "engine/study/methods/psychometric_function.h"
#include "engine/study/methods/wrong_value.h"

#include <fmt/core.h>

#include <cmath>

namespace springdrive::study {

namespace {

/// Of a normal density, F at u.
double normal_below(const Prior &prior, double u) {
    return core_proportion(Shape::cumulative_normal,
                           (u - on_scale(prior.scale, prior.mean)) / prior.deviation);
}

} // namespace

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

} // namespace springdrive::study
