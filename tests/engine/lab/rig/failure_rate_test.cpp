// Covers engine/lab/rig/failure_rate.cpp.
#include "engine/lab/rig/failure_rate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace springdrive::rig {
namespace {

TEST(FailureRate, NeedsThreeOverItsTrialsToBeExcluded) {
    EXPECT_EQ(trials_to_exclude(1e-4, 0.95), 29'956U);
    for (const double rate : {0.3, 0.01, 1e-3, 1e-6}) {
        const std::size_t trials = trials_to_exclude(rate, 0.95);
        EXPECT_NEAR(static_cast<double>(trials) * rate, std::log(20.0),
                    2.0 * rate + 0.55 * rate * 3)
            << rate;
        EXPECT_LE(rate_not_excluded(0, trials, 0.95), rate);
        EXPECT_GT(rate_not_excluded(0, trials - 1, 0.95), rate);
    }
}

TEST(FailureRate, IsThatOfPublishedTables) {
    // Upper limits of two-sided 95 % intervals, for example Zar, Biostatistical Analysis, table of
    // confidence limits for proportions.
    EXPECT_NEAR(rate_not_excluded(0, 10, 0.975), 0.3085, 5e-5);
    EXPECT_NEAR(rate_not_excluded(1, 10, 0.975), 0.4450, 5e-5);
    EXPECT_NEAR(rate_not_excluded(5, 50, 0.975), 0.2181, 5e-5);
    EXPECT_NEAR(rate_not_excluded(0, 100, 0.975), 0.0362, 5e-5);
    EXPECT_EQ(rate_not_excluded(0, 0, 0.95), 1.0);
    EXPECT_EQ(rate_not_excluded(7, 7, 0.95), 1.0);
}

TEST(FailureRate, IsExceededAsRarelyAsItSays) {
    // Trials at the limit itself: so few failures come about in 5 % of all repetitions.
    std::mt19937_64 random(1);
    constexpr std::size_t kTrials = 400;
    constexpr int kRepetitions = 20'000;
    for (const std::size_t failures : {0U, 1U, 4U, 20U}) {
        std::binomial_distribution<int> draw(kTrials, rate_not_excluded(failures, kTrials, 0.95));
        int as_few = 0;
        for (int i = 0; i < kRepetitions; ++i) {
            as_few += draw(random) <= static_cast<int>(failures) ? 1 : 0;
        }
        // Its standard deviation is 0.0015.
        EXPECT_NEAR(static_cast<double>(as_few) / kRepetitions, 0.05, 0.007) << failures;
    }
}

} // namespace
} // namespace springdrive::rig
