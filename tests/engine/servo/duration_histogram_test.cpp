// Covers engine/servo/duration_histogram.h.
#include "engine/servo/duration_histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace springdrive::servo {
namespace {

TEST(DurationHistogram, QuantilesAreWithinABinOfTheTrueOnes) {
    std::mt19937_64 random(10);
    std::lognormal_distribution<double> duration(-11.0, 1.5);
    std::vector<double> all;
    DurationHistogram histogram;
    for (int i = 0; i < 20'000; ++i) {
        all.push_back(duration(random));
        histogram.add(all.back());
    }
    std::sort(all.begin(), all.end());
    for (const double fraction : {0.01, 0.5, 0.99, 0.999}) {
        const double truth = all[static_cast<std::size_t>(std::ceil(fraction * 20'000.0)) - 1];
        EXPECT_NEAR(std::log2(histogram.quantile_s(fraction) / truth), 0.0, 1.0 / 64.0);
    }
    EXPECT_EQ(histogram.longest_s(), all.back());
    EXPECT_EQ(histogram.quantile_s(1.0), all.back());
    EXPECT_EQ(histogram.count(), 20'000U);
}

TEST(DurationHistogram, HandlesEmptyZeroAndInfinite) {
    DurationHistogram histogram;
    EXPECT_EQ(histogram.quantile_s(0.99), 0.0);
    EXPECT_EQ(histogram.mean_s(), 0.0);
    histogram.add(0.0);
    histogram.add(1e9);
    EXPECT_EQ(histogram.count(), 2U);
    EXPECT_EQ(histogram.quantile_s(1.0), 1e9);
}

} // namespace
} // namespace springdrive::servo
