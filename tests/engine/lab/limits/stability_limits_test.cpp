// Covers engine/lab/limits/stability_limits.cpp.
#include "engine/lab/limits/stability_limits.h"

#include "engine/lab/limits/simulated_limit.h"
#include "tests/support/random_loops.h"
#include "tests/support/runge_kutta_loop.h"
#include "tests/support/stability_cases.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <string_view>

namespace springdrive::limits {
namespace {

ParameterRange whole_range(const loops::StabilityParameter &parameter) {
    return {parameter.from, parameter.to};
}

/// An independent bisection, by Runge-Kutta alone, from a factor 1.3 on both sides.
double limit_by_runge_kutta(const loops::StabilityCase &which,
                            const loops::StabilityParameter &parameter,
                            const StabilityLimit &near) {
    const auto dies_out = [&](double value) {
        return testing::RungeKuttaLoop(testing::with(which, parameter, value)).dies_out();
    };
    double stable = near.stable_below ? near.predicted / 1.3 : near.predicted * 1.3;
    double unstable = near.stable_below ? near.predicted * 1.3 : near.predicted / 1.3;
    EXPECT_TRUE(dies_out(stable)) << parameter.name;
    EXPECT_FALSE(dies_out(unstable)) << parameter.name;
    while (std::abs(unstable - stable) > 1e-3 * stable) {
        const double middle = 0.5 * (stable + unstable);
        (dies_out(middle) ? stable : unstable) = middle;
    }
    return stable;
}

TEST(StabilityLimits, AreWhereRungeKuttaFindsThem) {
    constexpr std::array kNames{"kp", "kd", "dR", "T"};
    std::mt19937_64 random(11);
    int found = 0;
    for (std::size_t i = 0; found < 6; ++i) {
        const loops::StabilityParameter &parameter = testing::named(kNames[i % kNames.size()]);
        loops::StabilityCase which = testing::random_rotor_loop(random);
        // Windings that are ten times as fast take Runge-Kutta ten times as long.
        if (which.tuning.dR_Ohm / which.device.motor[1].inductance_H > 5e3) {
            continue;
        }
        const std::vector<StabilityLimit> limits =
            predicted_limits(which, parameter, whole_range(parameter));
        if (limits.size() != 1) { // another one may be within the factor 1.3
            continue;
        }
        ++found;
        const double truth = limit_by_runge_kutta(which, parameter, limits.front());
        // Bisection to 1e-3, and the slow growth of a mode near the limit over 4400 periods.
        EXPECT_NEAR(limits.front().predicted, truth, 3e-3 * truth) << parameter.name;
        const std::optional<double> tried =
            simulated_limit(which, parameter, limits.front(), TrialOptions::linear());
        ASSERT_TRUE(tried) << parameter.name;
        EXPECT_NEAR(*tried, truth, 0.01 * truth) << parameter.name;
    }
}

TEST(StabilityLimits, ThePredictedOneHasAStableAndAnUnstableSide) {
    std::mt19937_64 random(12);
    int found = 0;
    for (int i = 0; found < 100; ++i) {
        const loops::StabilityParameter &parameter =
            loops::stability_parameters()[static_cast<std::size_t>(i) % 13]; // all but the wall's
        loops::StabilityCase which = testing::random_rotor_loop(random);
        for (const StabilityLimit &limit :
             predicted_limits(which, parameter, whole_range(parameter))) {
            ++found;
            EXPECT_TRUE(loops::is_stable(testing::with(which, parameter, limit.predicted)))
                << parameter.name;
            const double outward = limit.stable_below ? 1.0 : -1.0;
            const double beyond = limit.predicted * (1.0 + outward * 2e-6);
            EXPECT_FALSE(loops::is_stable(testing::with(which, parameter, beyond)))
                << parameter.name;
        }
    }
}

TEST(StabilityLimits, NamesTheMemberThatFailsFirst) {
    const loops::StabilityParameter &kp = testing::named("kp");
    const std::vector<StabilityLimit> limits =
        predicted_limits(testing::firm(), kp, whole_range(kp));
    ASSERT_EQ(limits.size(), 1U);
    // Each motor and hand alone: the smallest of their limits is that of all.
    double minimum = 1e9;
    loops::LoopMember who;
    for (const loops::LoopMember &member : loops::members(testing::firm())) {
        double stable = 0.1;
        double unstable = 1e4;
        while (unstable - stable > 1e-7 * stable) {
            const double middle = 0.5 * (stable + unstable);
            (loops::largest_eigenvalue(testing::with(testing::firm(), kp, middle), member) < 1.0
                 ? stable
                 : unstable) = middle;
        }
        if (stable < minimum) {
            minimum = stable;
            who = member;
        }
    }
    EXPECT_NEAR(limits.front().predicted, minimum, 2e-6 * minimum);
    EXPECT_EQ(limits.front().worst.motor, who.motor);
    EXPECT_EQ(limits.front().worst.hand.name, who.hand.name);
    EXPECT_TRUE(limits.front().stable_below);
}

/// A delay may be any number of periods: its limit lies between the stable and the unstable whole
/// number.
TEST(StabilityLimits, OfADelayLieBetweenWholePeriods) {
    const loops::StabilityParameter &d = testing::named("d");
    const std::vector<StabilityLimit> limits = stability_limits(testing::firm(), d, whole_range(d));
    ASSERT_EQ(limits.size(), 1U);
    const double last = limits.front().predicted;
    EXPECT_TRUE(loops::is_stable(testing::with(testing::firm(), d, std::floor(last))));
    EXPECT_FALSE(loops::is_stable(testing::with(testing::firm(), d, std::ceil(last))));
    EXPECT_TRUE(loops::is_stable(testing::with(testing::firm(), d, last)));
    EXPECT_FALSE(loops::is_stable(
        testing::with(testing::firm(), d, last * (1.0 + 2e-6)))); // bisection to 1e-6
    ASSERT_TRUE(limits.front().simulated_linear);
    EXPECT_NEAR(*limits.front().simulated_linear, last, 0.01 * last);
}

TEST(StabilityLimits, ThereMayBeTwo) {
    // A filter may be too slow, and with K_D too fast.
    const loops::StabilityParameter &lambda = testing::named("lambda");
    std::mt19937_64 random(13);
    int twice = 0;
    for (int i = 0; i < 300 && twice == 0; ++i) {
        const loops::StabilityCase which = testing::random_rotor_loop(random);
        const std::vector<StabilityLimit> limits =
            predicted_limits(which, lambda, whole_range(lambda));
        if (limits.size() < 2) {
            continue;
        }
        ++twice;
        EXPECT_NE(limits[0].stable_below, limits[1].stable_below);
        EXPECT_LT(limits[0].predicted, limits[1].predicted);
    }
    EXPECT_EQ(twice, 1);
}

TEST(StabilityLimits, MayNotBeWithinTheRange) {
    EXPECT_TRUE(stability_limits(testing::firm(), testing::named("kp"), {0.1, 1.0}).empty());
    EXPECT_TRUE(stability_limits(testing::firm(), testing::named("kp"), {100.0, 200.0}).empty());
}

TEST(StabilityLimits, AZeroIsALimitToo) {
    // A winding alone, its rotor held by a stiff spring: it decays while dR > 0.
    loops::StabilityCase which = testing::firm();
    which.rotor = device::RotorLoad{1e-3, 6.3, 1e4};
    which.hands = {loops::no_hand()};
    which.tuning.K_P_V_per_rad = which.tuning.K_D_Vs_per_rad = 0.0;
    const std::vector<StabilityLimit> limits =
        predicted_limits(which, testing::named("dR"), {-1.0, 1.0});
    ASSERT_EQ(limits.size(), 1U);
    EXPECT_FALSE(limits.front().stable_below);
    EXPECT_NEAR(limits.front().predicted, 0.0, 1e-9);
}

TEST(StabilityLimits, HaveEveryKindOfTrial) {
    const loops::StabilityParameter &kp = testing::named("kp");
    const std::vector<StabilityLimit> limits =
        stability_limits(testing::firm(), kp, whole_range(kp));
    ASSERT_EQ(limits.size(), 1U);
    const StabilityLimit &limit = limits.front();
    ASSERT_TRUE(limit.simulated_linear && limit.simulated && limit.simulated_all);
    EXPECT_NEAR(*limit.simulated_linear, limit.predicted, 0.02 * limit.predicted);
    EXPECT_LT(*limit.simulated, limit.predicted);      // counts sustain vibration
    EXPECT_GT(*limit.simulated_all, *limit.simulated); // friction damps it
}

} // namespace
} // namespace springdrive::limits
