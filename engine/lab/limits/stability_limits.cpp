#include "engine/lab/limits/stability_limits.h"

#include "base/bisection.h"
#include "base/parallel.h"
#include "device/core/phantom/kinematics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <future>
#include <mutex>

namespace springdrive::limits {

namespace {

loops::StabilityCase with(loops::StabilityCase which, const loops::StabilityParameter &parameter,
                          double value) {
    parameter.set(which, value);
    return which;
}

using Holds = std::function<bool(double)>;

/// Values to try around a prediction: 0 is the prediction, positive shares lie on its unstable
/// side.
class Places {
public:
    Places(const loops::StabilityParameter &parameter, const StabilityLimit &limit)
        : parameter_(parameter), at_(limit.predicted), outward_(limit.stable_below ? 1.0 : -1.0) {}

    /// @param share  of the prediction
    [[nodiscard]] double value(double share) const {
        constexpr double kOfZero = 1e-9; // where a share would be zero
        const double away = share * std::max(std::abs(at_), kOfZero);
        return std::clamp(at_ + outward_ * away, parameter_.minimum, parameter_.maximum);
    }

private:
    const loops::StabilityParameter &parameter_;
    double at_;
    double outward_;
};

/// 1, 2, 4 … per cent to either side.
double by_doubling(const Places &places, int place) {
    return places.value(place == 0 ? 0.0
                                   : std::copysign(0.01 * std::exp2(std::abs(place) - 1), place));
}

/// From the prediction outwards to the nearest value at which a trial has the opposite result.
std::optional<Bracket> nearest_bracket(const Places &places, const Holds &holds) {
    constexpr int kFarthestInward = 7;  // 64 %
    constexpr int kFarthestOutward = 9; // 256 %
    const bool holds_there = holds(by_doubling(places, 0));
    const int step = holds_there ? 1 : -1;
    const int farthest = holds_there ? kFarthestOutward : kFarthestInward;
    for (int i = 1; i <= farthest; ++i) {
        const double last = by_doubling(places, step * (i - 1));
        const double value = by_doubling(places, step * i);
        if (value == last) { // the parameter's range ends
            return std::nullopt;
        }
        if (holds(value) != holds_there) {
            return holds_there ? Bracket{last, value} : Bracket{value, last};
        }
    }
    return std::nullopt;
}

constexpr int kStart = -7;      ///< half the prediction
constexpr int kInnermost = -11; ///< a tenth of it
constexpr int kOutermost = 19;  ///< four times it

/// Steps of a tenth inside, of a twentieth near the prediction, and growing by a fifth farther out.
double evenly(const Places &places, int place) {
    constexpr double kStep = 0.05;
    constexpr int kEven = 4; // to either side
    constexpr double kWider = 1.2;
    const double steps = place < -kEven   ? 2 * place + kEven
                         : place <= kEven ? place
                                          : kEven * std::pow(kWider, place - kEven);
    return places.value(kStep * steps);
}

/// The first value that fails, from well inside outwards.
/// @param predicted  whether a value is stable by the eigenvalues
std::optional<Bracket> first_bracket(const Places &places, const Holds &holds,
                                     const Holds &predicted) {
    const auto value = [&](int place) { return evenly(places, place); };
    const auto goes_on = [&](int from, int to) {
        return value(from) != value(to) && (to > 0 || predicted(value(to)));
    };
    int place = 0;
    while (place > kStart && goes_on(place, place - 1)) {
        --place;
    }
    if (!holds(value(place))) {
        for (int in = place - 1; in >= kInnermost && goes_on(in + 1, in); --in) {
            if (holds(value(in))) {
                return Bracket{value(in), value(in + 1)};
            }
        }
        do { // it comes to rest in the middle only, or nowhere
            ++place;
        } while (place <= 0 && !holds(value(place)));
        if (place > 0) {
            return std::nullopt;
        }
    }
    for (; place < kOutermost && goes_on(place, place + 1); ++place) {
        if (!holds(value(place + 1))) {
            return Bracket{value(place), value(place + 1)};
        }
    }
    return std::nullopt;
}

/// All members at a value; those that failed recently come first, so that failures are found early.
class Members {
public:
    Members(const loops::StabilityCase &which, const loops::StabilityParameter &parameter,
            const TrialOptions &options, double critical)
        : which_(which), parameter_(parameter), options_(options) {
        for (const loops::WorstMember &ranked : loops::ranked_members(at(critical))) {
            members_.push_back(ranked.member);
        }
    }

    [[nodiscard]] loops::StabilityCase at(double value) const {
        loops::StabilityCase there = which_;
        parameter_.set(there, value);
        return there;
    }

    bool hold(double value) { return hold_from(members_.begin(), value); }

    /// All but the one that failed last; where one of these fails, it becomes that one.
    bool others_hold(double value) { return hold_from(members_.begin() + 1, value); }

    /// The one that failed last.
    Trial critical(double value) { return trial(at(value), members_.front()); }

private:
    bool hold_from(std::vector<loops::LoopMember>::iterator first, double value) {
        const loops::StabilityCase there = at(value);
        const auto failed = std::find_if(first, members_.end(), [&](loops::LoopMember &member) {
            return !trial(there, member).stable;
        });
        if (failed == members_.end()) {
            return true;
        }
        std::rotate(members_.begin(), failed, failed + 1);
        return false;
    }

    [[nodiscard]] Trial trial(const loops::StabilityCase &there, loops::LoopMember &member) const {
        if (there.hands.size() == 1) { // its properties may be the varied parameter
            member.hand = there.hands.front();
        }
        return simulated(there, member, options_);
    }

    const loops::StabilityCase &which_;
    const loops::StabilityParameter &parameter_;
    const TrialOptions &options_;
    std::vector<loops::LoopMember> members_;
};

/// The limit to 1e-3 for the member that failed last, and for another member where that one fails
/// even earlier.
double limit_within(const Bracket &bracket, Members &members) {
    Bracket left = bracket;
    for (;;) {
        // A value at which the motion persists: no need to search more closely.
        std::optional<double> line;
        const auto holds = [&](double value) {
            if (!line) {
                const Trial trial = members.critical(value);
                if (!trial.stays) {
                    return trial.stable;
                }
                line = value;
            }
            return left.holds_at < left.fails_at ? value <= *line : value >= *line;
        };
        const double stable = last_that_holds(left, 1e-3, holds);
        if (stable == left.holds_at || members.others_hold(stable)) {
            return stable;
        }
        left.fails_at = stable;
    }
}

} // namespace

std::vector<double> spaced(const ParameterRange &range, int count, bool by_ratio) {
    std::vector<double> values;
    for (int i = 0; i < count; ++i) {
        const double share = count > 1 ? static_cast<double>(i) / (count - 1) : 0.0;
        values.push_back(by_ratio ? range.from * std::pow(range.to / range.from, share)
                                  : range.from + share * (range.to - range.from));
    }
    values.back() = range.to;
    return values;
}

std::vector<StabilityLimit> predicted_limits(const loops::StabilityCase &which,
                                             const loops::StabilityParameter &parameter,
                                             const ParameterRange &range) {
    const auto holds = [&](double value) {
        return loops::is_stable(with(which, parameter, value));
    };
    std::vector<StabilityLimit> limits;
    constexpr int kScanned = 60;
    const std::vector<double> values =
        spaced(range, kScanned, parameter.logarithmic && range.from > 0.0);
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

std::optional<double> simulated_limit(const loops::StabilityCase &which,
                                      const loops::StabilityParameter &parameter,
                                      const StabilityLimit &predicted,
                                      const TrialOptions &options) {
    Members members(which, parameter, options, predicted.predicted);
    const Holds holds = [&](double value) { return members.hold(value); };
    const Places places(parameter, predicted);
    const std::optional<Bracket> found =
        options.effects.any()
            ? first_bracket(places, holds,
                            [&](double value) { return loops::is_stable(members.at(value)); })
            : nearest_bracket(places, holds);
    if (!found) {
        return std::nullopt;
    }
    return limit_within(*found, members);
}

std::vector<StabilityLimit> stability_limits(const loops::StabilityCase &which,
                                             const loops::StabilityParameter &parameter,
                                             const ParameterRange &range) {
    std::vector<StabilityLimit> limits = predicted_limits(which, parameter, range);
    if (!which.is_rigid() && as_tried(which).is_rigid()) {
        return limits;
    }
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

namespace {

/// All members with one motor at a time; only the worst with the whole linkage, which takes fifty
/// times as long.
std::size_t tried(const loops::StabilityCase &which, std::size_t all) {
    constexpr std::size_t kOfLinkage = 2;
    return which.freedom == loops::Freedom::one_motor ? all : std::min(all, kOfLinkage);
}

/// The largest ratio of tip speed to rotor speed.
double lever_m(const loops::StabilityCase &which, const loops::LoopMember &member) {
    const Matrix3 J = device::motor_jacobian(which.device.geometry, which.q_rad);
    return which.freedom == loops::Freedom::one_motor ? J.col(member.motor).norm()
                                                      : J.colwise().norm().maxCoeff();
}

void fill(MapCell &cell, const loops::StabilityCase &there) {
    const loops::StabilityCase as_simulated = as_tried(there);
    const std::vector<loops::WorstMember> ranked = loops::ranked_members(as_simulated);
    const bool is_other = !there.is_rigid() && as_simulated.is_rigid();
    cell.eigenvalue = (is_other ? loops::worst_member(there) : ranked.front()).eigenvalue;
    TrialOptions options = TrialOptions::with(SimulationEffects::electronics());
    options.longest_s = 1.0;
    options.extension_s = 0.0;
    for (std::size_t i = 0; i < tried(there, ranked.size()) && cell.stable; ++i) {
        const Trial trial = simulated(there, ranked[i].member, options);
        cell.stable = trial.stable;
        cell.remaining_m_per_s = std::max(
            cell.remaining_m_per_s, trial.last_rate_rad_per_s * lever_m(there, ranked[i].member));
    }
}

} // namespace

std::vector<MapCell> stability_map(const loops::StabilityCase &which, const MapAxis &x,
                                   const MapAxis &y, const std::function<void(double)> &progress) {
    std::vector<MapCell> cells;
    for (const double at_y : y.values()) {
        for (const double at_x : x.values()) {
            cells.push_back({at_x, at_y, 0.0, true, 0.0});
        }
    }
    std::mutex progress_mutex;
    std::size_t done = 0;
    for_each_in_parallel(cells.size(), all_processors(), [&](std::size_t i) {
        loops::StabilityCase there = which;
        x.parameter->set(there, cells[i].x);
        y.parameter->set(there, cells[i].y);
        fill(cells[i], there);
        const std::lock_guard lock(progress_mutex);
        progress(static_cast<double>(++done) / static_cast<double>(cells.size()));
    });
    return cells;
}

} // namespace springdrive::limits
