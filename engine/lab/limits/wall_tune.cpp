#include "engine/lab/limits/drive_comparison.h"

#include "base/bisection.h"
#include "engine/lab/limits/stability_simulation.h"
#include "engine/lab/loops/tip_stiffness.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace springdrive::limits {

namespace {

constexpr double kFastest_rad_per_s = 5000.0; // as for the spring drive

/// Values spaced by a constant factor.
std::vector<double> by_ratio(double from, double to, int count) {
    std::vector<double> values;
    values.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        values.push_back(from * std::pow(to / from, static_cast<double>(i) / (count - 1)));
    }
    return values;
}

/// A loop whose plant is already discretised.
struct ReadyLoop {
    loops::StabilityCase which; ///< its freedom is used
    loops::LoopMember member;
    loops::LinearLoop loop;
};

class WallSearch {
public:
    WallSearch(const loops::StabilityCase &which, double margin, double max_count_N)
        : tried_(which), margin_(margin), max_count_N_(max_count_N) {
        for (const loops::Freedom freedom :
             {loops::Freedom::one_motor, loops::Freedom::three_motors}) {
            loops::StabilityCase each = which;
            each.freedom = freedom;
            for (const loops::LoopMember &member : loops::members(each)) {
                loops_.push_back({each, member, loops::linear_loop(each, member)});
            }
        }
        tried_.freedom = loops::Freedom::one_motor;
    }

    /// The largest K with this B and λ, if it is better than all before.
    void look_at(double B_Ns_per_m, double lambda_rad_per_s) {
        const double softest = std::max(kSoftest_N_per_m, 1.01 * best_.wall.stiffness_N_per_m);
        const auto wall = [&](double K) { return control::VirtualWall{K, B_Ns_per_m}; };
        const auto all_hold = [&](double K) {
            return holds(wall(K), lambda_rad_per_s) && rests(wall(K), lambda_rad_per_s);
        };
        if (!all_hold(softest)) {
            return;
        }
        const double loops = largest(softest, kStiffest_N_per_m, 1.001,
                                     [&](double K) { return holds(wall(K), lambda_rad_per_s); });
        const double K = rests(wall(loops), lambda_rad_per_s)
                             ? loops
                             : largest(softest, loops, 1.02, [&](double tried) {
                                   return rests(wall(tried), lambda_rad_per_s);
                               });
        best_ = {wall(K), lambda_rad_per_s};
    }

    [[nodiscard]] const TunedWall &best() const { return best_; }

private:
    static constexpr double kSoftest_N_per_m = 1.0;
    static constexpr double kStiffest_N_per_m = 1e6;

    /// The largest value that holds, between one that does and one that may not, to within a
    /// factor.
    template <typename Holds>
    static double largest(double stable, double unstable, double factor, const Holds &value_holds) {
        return bisect(
                   {stable, unstable},
                   [&](const Bracket &now) { return now.fails_at > now.holds_at * factor; },
                   value_holds,
                   [](const Bracket &now) { return std::sqrt(now.holds_at * now.fails_at); })
            .holds_at;
    }

    [[nodiscard]] bool rests(const control::VirtualWall &wall, double lambda_rad_per_s) {
        tried_.wall = wall;
        tried_.tuning.lambda_rad_per_s = lambda_rad_per_s;
        TrialOptions options = TrialOptions::with(SimulationEffects::electronics());
        options.longest_s = 1.5;
        options.extension_s = 0.0;
        return is_stable_simulated(tried_, options);
    }

    bool holds(const control::VirtualWall &wall, double lambda_rad_per_s) {
        tried_.wall = wall;
        tried_.tuning.lambda_rad_per_s = lambda_rad_per_s;
        if (loops::force_of_a_count_N(tried_) > max_count_N_) {
            return false;
        }
        for (std::size_t i = 0; i < loops_.size(); ++i) {
            if (!is_stable(loops_[i], wall, lambda_rad_per_s)) {
                // A member that fails now is likely to fail again.
                std::rotate(loops_.begin(), loops_.begin() + static_cast<std::ptrdiff_t>(i),
                            loops_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
                return false;
            }
        }
        return true;
    }

    [[nodiscard]] bool is_stable(ReadyLoop &loop, const control::VirtualWall &wall,
                                 double lambda_rad_per_s) const {
        loop.which.wall = {margin_ * wall.stiffness_N_per_m, margin_ * wall.damping_Ns_per_m};
        loop.which.tuning.lambda_rad_per_s = lambda_rad_per_s;
        return loop.loop.is_stable(loops::sampled_law(loop.which, loop.member));
    }

    loops::StabilityCase tried_;
    double margin_;
    double max_count_N_;
    std::vector<ReadyLoop> loops_;
    TunedWall best_;
};

} // namespace

TunedWall tuned_wall(loops::StabilityCase which, double margin, double max_count_N) {
    which.drive = device::AmplifierKind::current_drive;
    which.tuning.eta = 0.0;
    WallSearch search(which, margin, max_count_N);
    constexpr double kMin_Ns_per_m = 0.1;
    constexpr double kMax_Ns_per_m = 300.0;
    for (const double lambda : by_ratio(100.0, kFastest_rad_per_s, 9)) {
        for (const double B : by_ratio(kMin_Ns_per_m, kMax_Ns_per_m, 25)) {
            search.look_at(B, lambda);
        }
    }
    double factor = 1.2;
    while (factor > 1.02) { // ever finer steps
        const TunedWall centre = search.best();
        for (const double of_B : {1.0 / factor, 1.0, factor}) {
            for (const double of_lambda : {1.0 / factor, 1.0, factor}) {
                search.look_at(of_B * centre.wall.damping_Ns_per_m,
                               std::min(kFastest_rad_per_s, of_lambda * centre.lambda_rad_per_s));
            }
        }
        factor = std::sqrt(factor);
    }
    return search.best();
}

} // namespace springdrive::limits
