// Covers engine/lab/limits as a whole: predicted limits against simulated ones over many
// random loops. Takes a minute.
#include "engine/lab/limits/stability_limits.h"

#include "tests/support/cases.h"
#include "tests/support/delayed_limits.h"
#include "tests/support/random_loops.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>
#include <random>
#include <vector>

namespace springdrive::limits {
namespace {

constexpr std::size_t kLoopParameters = 13; ///< the list's others are the wall's

struct Found {
    loops::StabilityCase which;
    const loops::StabilityParameter *parameter = nullptr;
    StabilityLimit limit;
};

/// Random loops with a limit along one parameter; the parameters take turns.
std::vector<Found> random_limits(int count, std::mt19937_64 &random) {
    std::vector<Found> all;
    for (std::size_t i = 0; static_cast<int>(all.size()) < count; ++i) {
        Found found;
        found.which = testing::random_rotor_loop(random);
        found.parameter = &loops::stability_parameters()[i % kLoopParameters];
        const std::vector<StabilityLimit> limits = predicted_limits(
            found.which, *found.parameter, {found.parameter->from, found.parameter->to});
        if (!limits.empty()) {
            found.limit = limits.front();
            all.push_back(found);
        }
    }
    return all;
}

/// Where trials fail relative to the prediction: 1 at the prediction, above 1 beyond it. Nothing
/// where no trial nearby differs.
std::optional<double> lateness(const Found &found, const TrialOptions &options) {
    const std::optional<double> tried =
        simulated_limit(found.which, *found.parameter, found.limit, options);
    if (!tried) {
        return std::nullopt;
    }
    const double ratio = *tried / found.limit.predicted;
    return found.limit.stable_below ? ratio : 2.0 - ratio; // dR may go below zero
}

TEST(StabilityAgreement, RandomLoopsWithinTwoPerCent) {
    const int count = testing::cases(20, 200);
    std::mt19937_64 random(31);
    double worst = 0.0;
    for (const Found &found : random_limits(count, random)) {
        const std::optional<double> tried =
            simulated_limit(found.which, *found.parameter, found.limit, TrialOptions::linear());
        ASSERT_TRUE(tried) << found.parameter->name << " " << found.limit.predicted;
        EXPECT_NEAR(*tried, found.limit.predicted, 0.02 * std::abs(found.limit.predicted))
            << found.parameter->name << ", T " << found.which.period_s << ", d "
            << found.which.delay_periods;
        worst = std::max(worst, std::abs(*tried / found.limit.predicted - 1.0));
    }
    std::printf("worst of %d: %.2f %%\n", count, 100.0 * worst);
}

TEST(StabilityAgreement, LoopsWithAnyDelayWithinTwoPerCent) {
    const int count = testing::cases(10, 100);
    std::printf("worst of %d: %.2f %%\n", count,
                100.0 * testing::expect_gain_limits_agree(count, 34));
}

double share_of(const std::vector<double> &values, const std::function<bool(double)> &what) {
    return static_cast<double>(std::count_if(values.begin(), values.end(), what)) /
           static_cast<double>(values.size());
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(),
                     values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
}

/// Counts excite a loop with little damping, friction damps it: so they fail earlier and later,
/// respectively. Most of them: where a count is small compared with the accepted chatter, motion of
/// the last digit counts as rest slightly beyond the limit.
TEST(StabilityAgreement, CountsFailEarlierAndFrictionLater) {
    const int count = testing::cases(40, 200);
    std::mt19937_64 random(32);
    std::vector<double> with_counts;
    std::vector<double> with_friction;
    std::vector<double> friction_over_counts;
    for (const Found &found : random_limits(count, random)) {
        const auto counts = lateness(found, TrialOptions::with(SimulationEffects::electronics()));
        const auto all = lateness(found, TrialOptions::with(SimulationEffects::all()));
        if (counts) {
            with_counts.push_back(*counts);
        }
        if (all) {
            with_friction.push_back(*all);
        }
        if (counts && all) {
            friction_over_counts.push_back(*all - *counts);
        }
    }
    ASSERT_GT(static_cast<int>(friction_over_counts.size()), count * 3 / 4);
    const auto earlier = [](double late) { return late < 0.998; };
    const auto later = [](double late) { return late > 1.002; };
    std::printf("counts: median %.3f, earlier %.2f, later %.2f; with friction: median %.3f, "
                "earlier %.2f, later %.2f\n",
                median(with_counts), share_of(with_counts, earlier), share_of(with_counts, later),
                median(with_friction), share_of(with_friction, earlier),
                share_of(with_friction, later));
    EXPECT_LT(median(with_counts), 1.0);
    EXPECT_GT(share_of(with_counts, earlier), 2.0 * share_of(with_counts, later));
    EXPECT_GT(median(with_friction), 1.0);
    EXPECT_GT(share_of(with_friction, later), 2.0 * share_of(with_friction, earlier));
    // In the same loop friction does not make it fail earlier, within bisection's 1e-3.
    EXPECT_GT(share_of(friction_over_counts, [](double later_by) { return later_by > -2e-3; }),
              0.9);
}

/// Three motors anywhere in the workspace: prediction and trials agree within 2 %.
TEST(StabilityAgreement, ThreeMotorsWithinTwoPerCent) {
    std::mt19937_64 random(33);
    const loops::StabilityParameter &kp = *loops::stability_parameter_named("kp");
    const int count = testing::cases(10, 20);
    int tried = 0;
    while (tried < count) {
        testing::Draw draw(random);
        loops::StabilityCase which;
        which.device = tried % 2 == 0 ? testing::phantom_1_0() : testing::phantom_premium_1_5();
        for (device::MotorParameters &motor : which.device.motor) {
            motor.torque_constant_Nm_per_A *= draw.even(0.8, 1.25);
        }
        which.freedom = loops::Freedom::three_motors;
        which.q_rad = testing::random_workspace_angles(which.device, random);
        which.tuning.map =
            tried % 3 == 0 ? control::MotionMap::inverse : control::MotionMap::transpose;
        which.tuning.dR_Ohm = draw.by_ratio(0.1, 2.0);
        which.tuning.K_D_Vs_per_rad = draw.even(0.0, 0.02);
        which.tuning.lambda_rad_per_s = draw.by_ratio(300.0, 3000.0);
        which.period_s = draw.by_ratio(5e-4, 2e-3);
        which.delay_periods = draw.whole(0, 2);
        which.hands = {draw.whole(0, 2) == 0 ? loops::no_hand()
                                             : loops::hand_of_firmness(draw.even(0.0, 1.0))};
        const std::vector<StabilityLimit> limits = predicted_limits(which, kp, {0.01, 1000.0});
        if (limits.empty()) {
            continue;
        }
        ++tried;
        const StabilityLimit &limit = limits.front();
        const double outward = limit.stable_below ? 0.02 : -0.02;
        for (const double share : {1.0 - outward, 1.0 + outward}) {
            kp.set(which, share * limit.predicted);
            EXPECT_EQ(
                simulated(which, loops::members(which).front(), TrialOptions::linear()).stable,
                limit.stable_below == (share < 1.0))
                << "K_P " << share << " of " << limit.predicted << ", T " << which.period_s
                << ", hand " << which.hands.front().name << ", " << which.q_rad.transpose();
        }
    }
}

} // namespace
} // namespace springdrive::limits
