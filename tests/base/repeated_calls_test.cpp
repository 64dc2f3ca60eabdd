// Covers what calls a function again and again: base/bisection.h and base/timing.h.
#include "base/bisection.h"

#include "base/timing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace springdrive {
namespace {

TEST(LastThatHolds, IsFoundFromEitherSide) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> where(-10.0, 10.0);
    for (int trial = 0; trial < 200; ++trial) {
        const double line = where(random);
        const auto below = [&](double value) { return value < line; };
        const auto above = [&](double value) { return value > line; };
        for (const double share : {1e-3, 1e-6, 1e-9}) {
            // The boundary lies within a bracket of width w, w <= share (|line| + w).
            const double tolerance = share * std::abs(line) / (1.0 - share);
            const double up = last_that_holds({-20.0, 20.0}, share, below);
            const double down = last_that_holds({20.0, -20.0}, share, above);
            EXPECT_TRUE(below(up));
            EXPECT_TRUE(above(down));
            EXPECT_NEAR(up, line, tolerance) << line;
            EXPECT_NEAR(down, line, tolerance) << line;
        }
    }
}

TEST(LastThatHolds, EndsWithAnEmptyBracket) {
    const auto never = [](double) { return false; };
    const double none = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(last_that_holds({1.0, none}, 1e-6, never), 1.0);
    EXPECT_EQ(last_that_holds({1.0, 1.0}, 1e-6, never), 1.0);
}

TEST(Bisection, HalvesTheGivenNumberOfTimes) {
    int tried = 0;
    const auto holds = [&](double value) {
        ++tried;
        return value < std::sqrt(0.5);
    };
    const Bracket bracket = bisect({0.0, 1.0}, 20, holds);
    EXPECT_EQ(tried, 20);
    EXPECT_EQ(bracket.width(), std::ldexp(1.0, -20));
    EXPECT_LT(bracket.holds_at, std::sqrt(0.5));
    EXPECT_GE(bracket.fails_at, std::sqrt(0.5));
}

TEST(Bisection, TakesAnotherMiddle) {
    // Geometric mean: from 1 to 2^64 in six steps to a factor of two.
    int tried = 0;
    const Bracket bracket = bisect(
        {1.0, std::ldexp(1.0, 64)},
        [](const Bracket &now) { return now.fails_at > 2.0 * now.holds_at; },
        [&](double value) {
            ++tried;
            return value <= 1000.0;
        },
        [](const Bracket &now) { return std::sqrt(now.holds_at * now.fails_at); });
    EXPECT_EQ(tried, 6);
    EXPECT_EQ(bracket.holds_at, 512.0);
    EXPECT_EQ(bracket.fails_at, 1024.0);
}

TEST(Timing, LeastMedianAndGreatestOfTimes) {
    const Cost odd = cost_of_times({5.0, 1.0, 9.0});
    EXPECT_EQ(odd.min_ns, 1.0);
    EXPECT_EQ(odd.median_ns, 5.0);
    EXPECT_EQ(odd.max_ns, 9.0);
    EXPECT_EQ(cost_of_times({4.0, 1.0, 3.0, 2.0}).median_ns, 2.5);
    EXPECT_EQ(cost_of_times({7.0}).median_ns, 7.0);
}

TEST(Timing, RunsOnceMoreThanItRepeats) {
    int runs = 0;
    const Cost cost = cost_of(6, 10.0, [&] { ++runs; });
    EXPECT_EQ(runs, 7);
    EXPECT_GE(cost.min_ns, 0.0);
    EXPECT_LE(cost.min_ns, cost.median_ns);
    EXPECT_LE(cost.median_ns, cost.max_ns);
}

} // namespace
} // namespace springdrive
