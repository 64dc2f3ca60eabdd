#include "engine/analysis/stability/stability_limits.h"

#include <algorithm>
#include <cmath>
#include <future>

namespace springdrive {

namespace {

constexpr int kScanned = 60;

StabilityCase with(StabilityCase which, const StabilityParameter &parameter, double value) {
    parameter.set(which, value);
    return which;
}

/// The values of a range, evenly spread by the parameter's own scale.
std::vector<double> scan(const StabilityParameter &parameter, const ParameterRange &range) {
    std::vector<double> values;
    if (parameter.whole) {
        const int steps = static_cast<int>(range.to - range.from);
        for (int i = 0; i <= steps; ++i) {
            values.push_back(range.from + i);
        }
        return values;
    }
    const bool by_ratio = parameter.logarithmic && range.from > 0.0;
    for (int i = 0; i < kScanned; ++i) {
        const double share = static_cast<double>(i) / (kScanned - 1);
        values.push_back(by_ratio ? range.from * std::pow(range.to / range.from, share)
                                  : range.from + share * (range.to - range.from));
    }
    values.back() = range.to;
    return values;
}

/// Between a value that is stable and one that is not, to `share` of it; whole numbers to 1.
double last_stable(double stable, double unstable, double share, bool whole,
                   const std::function<bool(double)> &holds) {
    const auto apart = [&] { return std::abs(unstable - stable); };
    while (whole ? apart() > 1.0
                 : apart() > share * std::max(std::abs(stable), std::abs(unstable))) {
        const double middle = 0.5 * (stable + unstable);
        const double tried = whole ? std::round(middle) : middle;
        (holds(tried) ? stable : unstable) = tried;
    }
    return stable;
}

/// A bracket of one trial that is stable and one that is not.
struct Bracket {
    double stable = 0.0;
    double unstable = 0.0;
};

/// Steps from the prediction, on either side, until a trial differs from what is predicted there.
std::optional<Bracket> bracket(const StabilityParameter &parameter, const StabilityLimit &limit,
                               const std::function<bool(double)> &holds) {
    const double at = limit.predicted;
    const double outward = limit.stable_below ? 1.0 : -1.0; // towards instability
    const auto inside = [&](double value) {
        return std::clamp(value, parameter.lowest, parameter.highest);
    };
    // By shares of the value; 0 and whole numbers have none.
    const auto beside = [&](double share) {
        const double step = parameter.whole ? std::ceil(std::log2(1.0 + share) * 100.0 / 3.0)
                                            : share * std::max(std::abs(at), 1e-9);
        return inside(at + outward * step);
    };
    constexpr double kFirst = 0.01;
    constexpr double kFarthest = 3.0;
    if (const bool too_far = !holds(at); too_far) { // the trial fails earlier than predicted
        double unstable = at;
        double share = kFirst;
        while (share < 1.0) {
            const double value =
                parameter.whole ? inside(unstable - outward) : inside(at * (1.0 - outward * share));
            if (value == unstable) {
                return std::nullopt;
            }
            if (holds(value)) {
                return Bracket{value, unstable};
            }
            unstable = value;
            share *= 2.0;
        }
        return std::nullopt;
    }
    double stable = at;
    double share = kFirst;
    while (share < kFarthest) {
        const double value = parameter.whole ? inside(stable + outward) : beside(share);
        if (value == stable) {
            return std::nullopt;
        }
        if (!holds(value)) {
            return Bracket{stable, value};
        }
        stable = value;
        share *= 2.0;
    }
    return std::nullopt;
}

} // namespace

std::vector<StabilityLimit> predicted_limits(const StabilityCase &which,
                                             const StabilityParameter &parameter,
                                             const ParameterRange &range) {
    const auto holds = [&](double value) { return is_stable(with(which, parameter, value)); };
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
            limit.predicted = last_stable(stable, unstable, 1e-6, parameter.whole, holds);
            const double beyond = limit.predicted + (unstable - stable) * 1e-3;
            limit.worst =
                worst_member(with(which, parameter, parameter.whole ? unstable : beyond)).member;
            limits.push_back(limit);
        }
        before = after;
    }
    return limits;
}

std::optional<double> simulated_limit(const StabilityCase &which,
                                      const StabilityParameter &parameter,
                                      const StabilityLimit &predicted,
                                      const TrialOptions &options) {
    // The most critical first, so that trials end early.
    const std::vector<WorstMember> order =
        ranked_members(with(which, parameter, predicted.predicted));
    const auto holds = [&](double value) {
        const StabilityCase there = with(which, parameter, value);
        return std::all_of(order.begin(), order.end(), [&](const WorstMember &ranked) {
            LoopMember same = ranked.member;
            if (there.hands.size() == 1) { // its properties may be what is varied
                same.hand = there.hands.front();
            }
            return simulated(there, same, options).stable;
        });
    };
    const std::optional<Bracket> found = bracket(parameter, predicted, holds);
    if (!found) {
        return std::nullopt;
    }
    return last_stable(found->stable, found->unstable, 1e-3, parameter.whole, holds);
}

std::vector<StabilityLimit> stability_limits(const StabilityCase &which,
                                             const StabilityParameter &parameter,
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

} // namespace springdrive
