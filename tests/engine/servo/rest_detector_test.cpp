// Covers engine/servo/rest_detector.h.
#include "engine/servo/rest_detector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace springdrive::servo {
namespace {

constexpr double kWatchPeriod_s = 1e-3;
const Vector3 kPlace_m(0.05, -0.02, 0.01);

/// Ticks until it is at rest, with the tip at `tip_m(tick)`; −1 if not within a second.
template <typename Path> int ticks_to_rest(RestDetector &watch, Path tip_m, double period_s) {
    const int longest = static_cast<int>(1.0 / period_s);
    for (int tick = 1; tick <= longest; ++tick) {
        watch.update(tip_m(tick), false);
        if (watch.is_at_rest()) {
            return tick;
        }
    }
    return -1;
}

TEST(RestDetector, NeedsATenthOfASecondInOnePlaceAtAnyRate) {
    for (const double rate_hz : {250.0, 1000.0, 3000.0, 10'000.0}) {
        RestDetector watch(1.0 / rate_hz);
        const int ticks = ticks_to_rest(
            watch, [](int) { return kPlace_m; }, 1.0 / rate_hz);
        // The first tick sets the position; round-off in a sum of a thousand periods may require
        // one more.
        EXPECT_GE(ticks, 0.1 * rate_hz);
        EXPECT_LE(ticks, 0.1 * rate_hz + 2.0);
    }
}

TEST(RestDetector, OscillationUpToAMillimetreIsRest) {
    const auto oscillation = [](double reach_m) {
        return [reach_m](int tick) {
            return Vector3(kPlace_m + Vector3(0.0, tick % 2 == 0 ? reach_m : 0.0, 0.0));
        };
    };
    RestDetector resting(kWatchPeriod_s);
    EXPECT_GT(ticks_to_rest(resting, oscillation(0.999e-3), kWatchPeriod_s), 0);
    RestDetector moving(kWatchPeriod_s);
    EXPECT_EQ(ticks_to_rest(moving, oscillation(1.001e-3), kWatchPeriod_s), -1);
}

TEST(RestDetector, ADriftUpToOneCentimetrePerSecondIsRest) {
    const auto drift = [](double speed_m_per_s) {
        return [speed_m_per_s](int tick) {
            return Vector3(kPlace_m + Vector3(speed_m_per_s * kWatchPeriod_s * tick, 0.0, 0.0));
        };
    };
    RestDetector slow(kWatchPeriod_s);
    EXPECT_GT(ticks_to_rest(slow, drift(0.0098), kWatchPeriod_s), 0);
    RestDetector fast(kWatchPeriod_s);
    EXPECT_EQ(ticks_to_rest(fast, drift(0.0105), kWatchPeriod_s), -1);
}

TEST(RestDetector, ATouchingTipIsNeverAtRest) {
    RestDetector watch(kWatchPeriod_s);
    for (int tick = 0; tick < 1000; ++tick) {
        watch.update(kPlace_m, true);
        ASSERT_FALSE(watch.is_at_rest());
    }
    // A touch shortly before the end restarts the time.
    EXPECT_GT(ticks_to_rest(
                  watch, [](int) { return kPlace_m; }, kWatchPeriod_s),
              99);
    for (int tick = 0; tick < 99; ++tick) {
        watch.update(kPlace_m, tick == 0);
        ASSERT_FALSE(watch.is_at_rest()) << tick;
    }
}

TEST(RestDetector, ANonFiniteTipIsNotAtRest) {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        RestDetector watch(kWatchPeriod_s);
        const Vector3 nowhere_m(0.0, bad, 0.0);
        EXPECT_EQ(ticks_to_rest(
                      watch, [&](int) { return nowhere_m; }, kWatchPeriod_s),
                  -1);
        EXPECT_GT(ticks_to_rest(
                      watch, [](int) { return kPlace_m; }, kWatchPeriod_s),
                  0); // it recovers
    }
}

TEST(RestDetector, AResetRestartsTheTime) {
    RestDetector watch(kWatchPeriod_s);
    ASSERT_GT(ticks_to_rest(
                  watch, [](int) { return kPlace_m; }, kWatchPeriod_s),
              0);
    watch.reset();
    EXPECT_FALSE(watch.is_at_rest());
    EXPECT_GE(ticks_to_rest(
                  watch, [](int) { return kPlace_m; }, kWatchPeriod_s),
              100);
}

} // namespace
} // namespace springdrive::servo
