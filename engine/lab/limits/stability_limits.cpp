#include "engine/lab/limits/stability_limits.h"

#include "base/bisection.h"
#include "engine/lab/limits/simulated_limit.h"

#include <cmath>
#include <future>

namespace springdrive::limits {

namespace {

constexpr int kScanned = 60;

loops::StabilityCase with(loops::StabilityCase which, const loops::StabilityParameter &parameter,
                          double value) {
    parameter.set(which, value);
    return which;
}

/// The values of a range, evenly spaced on the parameter's scale.
std::vector<double> scan(const loops::StabilityParameter &parameter, const ParameterRange &range) {
    std::vector<double> values;
    const bool by_ratio = parameter.logarithmic && range.from > 0.0;
    for (int i = 0; i < kScanned; ++i) {
        const double share = static_cast<double>(i) / (kScanned - 1);
        values.push_back(by_ratio ? range.from * std::pow(range.to / range.from, share)
                                  : range.from + share * (range.to - range.from));
    }
    values.back() = range.to;
    return values;
}

} // namespace

std::vector<StabilityLimit> predicted_limits(const loops::StabilityCase &which,
                                             const loops::StabilityParameter &parameter,
                                             const ParameterRange &range) {
    const auto holds = [&](double value) {
        return loops::is_stable(with(which, parameter, value));
    };
    std::vector<StabilityLimit> limits;
    const std::vector<double> values = scan(parameter, range);
    bool before = holds(values.front());
    for (std::size_t i = 1; i < values.size(); ++i) {
        const bool after = holds(values[i]);
        if (after != before) {
            StabilityLimit limit;
            limit.stable_below = before;
            const double stable = before ? values[i - 1] : values[i];
            const double unstable = before ? values[i] : values[i - 1];
            limit.predicted = last_that_holds({stable, unstable}, 1e-6, holds);
            const double beyond = limit.predicted + (unstable - stable) * 1e-3;
            limit.worst = loops::worst_member(with(which, parameter, beyond)).member;
            limits.push_back(limit);
        }
        before = after;
    }
    return limits;
}

std::vector<StabilityLimit> stability_limits(const loops::StabilityCase &which,
                                             const loops::StabilityParameter &parameter,
                                             const ParameterRange &range) {
    std::vector<StabilityLimit> limits = predicted_limits(which, parameter, range);
    const auto search = [&](const StabilityLimit &limit, const TrialOptions &options) {
        return std::async(std::launch::async, [&which, &parameter, &limit, options] {
            return simulated_limit(which, parameter, limit, options);
        });
    };
    for (StabilityLimit &limit : limits) {
        auto all = search(limit, TrialOptions::with(SimulationEffects::all()));
        auto electronics = search(limit, TrialOptions::with(SimulationEffects::electronics()));
        limit.simulated_linear = simulated_limit(which, parameter, limit, TrialOptions::linear());
        limit.simulated = electronics.get();
        limit.simulated_all = all.get();
    }
    return limits;
}

} // namespace springdrive::limits
