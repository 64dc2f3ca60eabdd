// Covers engine/lab/rig/quantisation_chatter.h.
#include "engine/lab/rig/quantisation_chatter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace springdrive::rig {
namespace {

constexpr double kChatterPeriod_s = 1e-3;

/// When it is known to be all flicker [s]; infinite where not within 10 s.
double known_after_s(const std::function<Vector3(double)> &motion, double max_range_rad,
                     double lasting_s = 0.4) {
    QuantisationChatter chatter(max_range_rad, lasting_s, kChatterPeriod_s);
    for (int k = 0; k < 10000; ++k) {
        if (chatter.is_all()) {
            return k * kChatterPeriod_s;
        }
        chatter.watch(motion(k * kChatterPeriod_s));
    }
    return HUGE_VAL;
}

Vector3 swing(double amplitude_rad, double time_s) {
    return amplitude_rad * std::cos(2.0 * M_PI * 40.0 * time_s) * Vector3(0.3, -1.0, 0.5);
}

TEST(QuantisationChatter, IsWhatGoesNoFartherForLongEnough) {
    // To and fro is twice the amplitude.
    EXPECT_NEAR(known_after_s([](double t) { return swing(0.99, t); }, 2.0), 0.4, 1e-9);
    EXPECT_EQ(known_after_s([](double t) { return swing(1.01, t); }, 2.0), HUGE_VAL);
}

TEST(QuantisationChatter, MayBeAnywhere) {
    const Vector3 away(100.0, -3.0, 7.0);
    EXPECT_NEAR(known_after_s([&](double t) { return Vector3(away + swing(0.9, t)); }, 2.0), 0.4,
                1e-9);
}

TEST(QuantisationChatter, IsSeenOnceAMotionHasDied) {
    // e^(−5t) is 1/40 at 0.738 s; half a swing of 12.5 ms and a sample are the rest.
    const auto dying = [](double t) { return swing(40.0 * std::exp(-5.0 * t), t); };
    EXPECT_NEAR(known_after_s(dying, 2.0), 0.738 + 0.4, 0.015);
}

TEST(QuantisationChatter, BeginsAnewWithEveryLeap) {
    const auto leaps = [](double every_s) {
        return [=](double t) { return Vector3(5.0 * std::floor(t / every_s + 1e-6), 0.0, 0.0); };
    };
    EXPECT_EQ(known_after_s(leaps(0.39), 2.0), HUGE_VAL);
    EXPECT_NEAR(known_after_s(leaps(0.41), 2.0), 0.4, 1e-9);
}

TEST(QuantisationChatter, WithoutCountsIsOnlyWhatStandsStill) {
    EXPECT_NEAR(known_after_s([](double) { return Vector3(1.0, 2.0, 3.0); }, 0.0), 0.4, 1e-9);
    EXPECT_EQ(known_after_s([](double t) { return swing(1e-9, t); }, 0.0), HUGE_VAL);
}

TEST(QuantisationChatter, IsNotWhatIsNoNumber) {
    EXPECT_EQ(known_after_s([](double) { return Vector3(0.0, NAN, 0.0); }, 2.0), HUGE_VAL);
}

TEST(QuantisationChatter, MayBeAllUntilItGoesTooFar) {
    QuantisationChatter chatter(2.0, 0.4, kChatterPeriod_s);
    chatter.watch(Vector3::Zero());
    EXPECT_TRUE(chatter.may_be_all());
    chatter.watch(Vector3(0.0, 1.9, 0.0));
    EXPECT_TRUE(chatter.may_be_all());
    chatter.watch(Vector3(0.0, -0.2, 0.0));
    EXPECT_FALSE(chatter.may_be_all());
    chatter.watch(Vector3(0.0, -0.2, 0.0));
    EXPECT_TRUE(chatter.may_be_all());
    EXPECT_FALSE(chatter.is_all());
}

} // namespace
} // namespace springdrive::rig
