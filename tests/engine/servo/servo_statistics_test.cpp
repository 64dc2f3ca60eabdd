// Covers engine/servo/servo_statistics.h.
#include "engine/servo/servo_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace springdrive::servo {
namespace {

TEST(ServoStatistics, AccumulatesTheSamples) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> duration_s(1e-6, 1e-3);
    ServoStatistics statistics;
    std::vector<double> period_s;
    std::vector<double> lateness_s;
    double read_s = 0.0;
    double longest_compute_s = 0.0;
    std::uint64_t missed = 0;
    constexpr int kTicks = 2000;
    for (int tick = 0; tick < kTicks; ++tick) {
        ServoSample sample;
        sample.missed_deadlines = static_cast<std::uint32_t>(random() % 3);
        missed += sample.missed_deadlines;
        if (tick > 0) { // the first has no predecessor
            sample.period_s = duration_s(random);
            period_s.push_back(sample.period_s);
        }
        sample.lateness_s = duration_s(random);
        lateness_s.push_back(sample.lateness_s);
        sample.read_s = duration_s(random);
        read_s += sample.read_s;
        sample.compute_s = duration_s(random);
        longest_compute_s = std::max(longest_compute_s, sample.compute_s);
        statistics.add(sample);
    }
    EXPECT_EQ(statistics.ticks(), kTicks);
    EXPECT_EQ(statistics.missed_deadlines(), missed);
    EXPECT_EQ(statistics.period().count(), kTicks - 1);
    EXPECT_EQ(statistics.period().longest_s(), *std::max_element(period_s.begin(), period_s.end()));
    EXPECT_EQ(statistics.lateness().longest_s(),
              *std::max_element(lateness_s.begin(), lateness_s.end()));
    EXPECT_NEAR(statistics.read().mean_s(), read_s / kTicks, 1e-12);
    EXPECT_EQ(statistics.compute().longest_s(), longest_compute_s);
    std::sort(lateness_s.begin(), lateness_s.end());
    EXPECT_NEAR(std::log2(statistics.lateness().quantile_s(0.5) / lateness_s[kTicks / 2 - 1]), 0.0,
                1.0 / 64.0);
}

TEST(ServoStatistics, HaveNoTimesInLockstep) {
    ServoStatistics statistics;
    for (int tick = 0; tick < 10; ++tick) {
        statistics.add(ServoSample{});
    }
    EXPECT_EQ(statistics.ticks(), 10U);
    EXPECT_EQ(statistics.missed_deadlines(), 0U);
    EXPECT_EQ(statistics.period().count(), 0U);
    EXPECT_EQ(statistics.lateness().count(), 0U);
    EXPECT_EQ(statistics.read().count(), 0U);
    EXPECT_EQ(statistics.compute().count(), 0U);
}

} // namespace
} // namespace springdrive::servo
