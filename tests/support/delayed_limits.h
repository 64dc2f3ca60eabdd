// Gain limits of loops with a fractional delay: eigenvalues compared with two simulations.
#pragma once

#include "engine/lab/limits/stability_limits.h"
#include "tests/support/random_loops.h"
#include "tests/support/runge_kutta_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

namespace springdrive::testing {

/// Expects Runge-Kutta to agree with the eigenvalues 2 % inside and 2 % outside of a limit of K_P.
inline void expect_runge_kutta_agrees(const loops::StabilityCase &which,
                                      const limits::StabilityLimit &limit) {
    const double outward = limit.stable_below ? 0.02 : -0.02;
    for (const double share : {1.0 - outward, 1.0 + outward}) {
        loops::StabilityCase beside = which;
        beside.tuning.K_P_V_per_rad = share * limit.predicted;
        EXPECT_EQ(RungeKuttaLoop(beside).dies_out(), limit.stable_below == (share < 1.0))
            << "K_P " << share << " of " << limit.predicted << ", T " << which.period_s << ", d "
            << which.delay_periods;
    }
}

/// For random loops with d from 0 to 3: the K_P at which they become unstable, by eigenvalues, is
/// within 2 % of that of a simulated motor, and on the correct side by Runge-Kutta steps. Returns
/// the largest relative deviation of the former.
inline double expect_gain_limits_agree(int loops, unsigned seed) {
    std::mt19937_64 random(seed);
    const loops::StabilityParameter &kp = *loops::stability_parameter_named("kp");
    double worst = 0.0;
    for (int found = 0; found < loops;) {
        const loops::StabilityCase which = random_delayed_loop(random);
        const std::vector<limits::StabilityLimit> limits =
            limits::predicted_limits(which, kp, {kp.from, kp.to});
        if (limits.empty()) {
            continue;
        }
        ++found;
        const limits::StabilityLimit &limit = limits.front();
        const std::optional<double> tried =
            limits::simulated_limit(which, kp, limit, limits::TrialOptions::linear());
        EXPECT_TRUE(tried) << limit.predicted << ", d " << which.delay_periods;
        const double deviation = std::abs(tried.value_or(HUGE_VAL) / limit.predicted - 1.0);
        EXPECT_LE(deviation, 0.02) << "T " << which.period_s << ", d " << which.delay_periods;
        worst = std::max(worst, deviation);
        expect_runge_kutta_agrees(which, limit);
    }
    return worst;
}

} // namespace springdrive::testing
