// Covers base/timing.h.
#include "base/timing.h"

#include <gtest/gtest.h>

namespace springdrive {
namespace {

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
