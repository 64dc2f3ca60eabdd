// Covers engine/lab/rig/ringdown.cpp.
#include "engine/lab/rig/ringdown.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace springdrive::rig {
namespace {

constexpr double kPeriod_s = 1e-3;

Ringdown watched(const std::function<double(double)> &motion, const RingdownOptions &options = {},
                 double period_s = kPeriod_s) {
    Ringdown ringdown(options, period_s);
    for (int k = 0; ringdown.watch(std::abs(motion(k * period_s))); ++k) {
    }
    return ringdown;
}

double oscillation(double time_s, double rate_per_s, double frequency_hz) {
    return std::exp(rate_per_s * time_s) * std::cos(2.0 * M_PI * frequency_hz * time_s);
}

TEST(Ringdown, TellsGrowthFromDecayOnBothSidesOfZero) {
    for (const double rate : {30.0, 3.0, 0.3, 0.1}) {
        for (const double frequency : {0.0, 30.0, 170.0, 499.0}) {
            for (const double sign : {-1.0, 1.0}) {
                const Ringdown ringdown =
                    watched([&](double t) { return oscillation(t, sign * rate, frequency); });
                EXPECT_EQ(ringdown.dies_out(), sign < 0.0) << rate << "/s, " << frequency << " Hz";
            }
        }
    }
}

TEST(Ringdown, MeasuresTheRate) {
    for (const double rate : {-3.0, -0.5, 0.0, 0.5, 2.0}) {
        for (const double size : {1e-9, 1.0, 1e9}) {
            const Ringdown ringdown =
                watched([&](double t) { return size * oscillation(t, rate, 60.0); });
            // The greatest of a window is found to a sample: 1 − cos(2π 60 Hz 0.5 ms), 2 %, of
            // which windows of whole turns have the same share; a second half of 1.5 s evens it.
            EXPECT_NEAR(ringdown.growth_per_s(), rate, 0.02) << size;
        }
    }
}

TEST(Ringdown, MeasuresTheRateAtAnyPeriod) {
    for (const double period_s : {1e-5, 1e-4, 7e-3, 0.0123, 0.05, 0.5}) {
        for (const double rate : {-0.7, 0.7}) {
            const Ringdown ringdown =
                watched([&](double t) { return std::exp(rate * t); }, RingdownOptions{}, period_s);
            EXPECT_NEAR(ringdown.growth_per_s(), rate, 1e-6) << period_s << " s";
            EXPECT_EQ(ringdown.dies_out(), rate < 0.0) << period_s << " s";
        }
    }
}

TEST(Ringdown, EndsEarlyWhereThereIsNothingMoreToSee) {
    const auto samples_to_the_end = [](double rate_per_s) {
        Ringdown ringdown({}, kPeriod_s);
        int k = 0;
        while (ringdown.watch(std::exp(rate_per_s * k * kPeriod_s))) {
            ++k;
        }
        return k + 1;
    };
    EXPECT_EQ(samples_to_the_end(0.0), 3000); // all of it
    EXPECT_LT(samples_to_the_end(-100.0), 500);
    EXPECT_LT(samples_to_the_end(100.0), 500);
}

TEST(Ringdown, TakesWhatIsNotANumberForRunningAway) {
    for (const double bad : {std::numeric_limits<double>::infinity(), std::nan("")}) {
        Ringdown ringdown({}, kPeriod_s);
        EXPECT_TRUE(ringdown.watch(1.0));
        EXPECT_FALSE(ringdown.watch(bad));
        EXPECT_FALSE(ringdown.dies_out());
        EXPECT_GT(ringdown.growth_per_s(), 1e300);
    }
}

TEST(Ringdown, SeesWhatExplodesWithinTheFirstWindow) {
    for (const double per_sample : {2.0, 1e3, 1e30, 1e200}) {
        Ringdown ringdown({}, kPeriod_s);
        double magnitude = 1e-5;
        while (ringdown.watch(magnitude)) {
            magnitude *= per_sample;
        }
        EXPECT_FALSE(ringdown.dies_out()) << per_sample;
    }
}

TEST(Ringdown, WhatComesToMoreThanAllowedHasRunAway) {
    RingdownOptions options;
    options.maximum = 100.0;
    for (const double peak : {99.0, 101.0}) {
        // Up within a sample, then slowly down: in the end it decays.
        const Ringdown ringdown =
            watched([peak](double t) { return t == 0.0 ? 1.0 : peak * std::exp(-t); }, options);
        EXPECT_EQ(ringdown.dies_out(), peak < 100.0);
    }
}

TEST(Ringdown, ABurstThatComesToRestDiesOut) {
    // Grows to 500 times itself, then falls: what a linear loop with far poles may do.
    const Ringdown ringdown = watched([](double t) {
        return t < 0.3 ? std::exp(t / 0.3 * std::log(500.0)) : 500.0 * std::exp(-20.0 * (t - 0.3));
    });
    EXPECT_TRUE(ringdown.dies_out());
}

TEST(Ringdown, WantsALeastDecayOfMotionsThatCountsKeepUp) {
    RingdownOptions options;
    options.min_decay_per_s = 0.5;
    const auto dies_out = [&options](double rate_per_s) {
        return watched([&](double t) { return std::exp(rate_per_s * t); }, options).dies_out();
    };
    EXPECT_TRUE(dies_out(-0.6));
    EXPECT_FALSE(dies_out(-0.4));
    // Fast, but it has not come to half of what it was at first.
    EXPECT_FALSE(
        watched([](double t) { return t < 1.6 ? 1.0 : std::exp(-0.45 * (t - 1.6)); }, options)
            .dies_out());
}

TEST(Ringdown, WithPatienceTellsWhatIsSlow) {
    // Two motions, the one that grows hidden at first. After 30 s it is 20 times the other.
    const auto motion = [](double grows_per_s) {
        return [=](double t) {
            return oscillation(t, -0.12, 2.3) + 0.1 * oscillation(t, grows_per_s, 5.1);
        };
    };
    RingdownOptions options;
    options.window_s = 0.3;
    for (const double grows_per_s : {0.06, 0.1}) {
        options.extension_s = 0.0;
        EXPECT_TRUE(watched(motion(grows_per_s), options).dies_out());
        options.extension_s = 30.0;
        EXPECT_FALSE(watched(motion(grows_per_s), options).dies_out());
        EXPECT_TRUE(watched(motion(-grows_per_s), options).dies_out());
    }
}

TEST(Ringdown, IsPatientOnlyWhereItIsUnclear) {
    RingdownOptions options;
    options.extension_s = 30.0;
    const auto watched_s = [&](double rate_per_s) {
        Ringdown ringdown(options, kPeriod_s);
        int k = 0;
        while (ringdown.watch(std::exp(rate_per_s * k * kPeriod_s))) {
            ++k;
        }
        return (k + 1) * kPeriod_s;
    };
    EXPECT_NEAR(watched_s(0.0), 30.0, 1e-9);
    EXPECT_NEAR(watched_s(-1.0), 3.0, 1e-9);
    EXPECT_NEAR(watched_s(1.0), 3.0, 1e-9);
    // Half of 14 s at 0.1/s are a factor of two, half of 24 s one of three; a window more or two.
    EXPECT_NEAR(watched_s(0.1), 14.0, 0.3);
    EXPECT_NEAR(watched_s(-0.1), 24.0, 0.3);
    // With a least decay it is unclear while the motion falls.
    options.min_decay_per_s = 0.2;
    EXPECT_NEAR(watched_s(-0.1), 3.0, 1e-9);
    EXPECT_NEAR(watched_s(-0.4), 30.0, 1e-9);
}

TEST(Ringdown, WhatStaysIsNeitherSlowNorClear) {
    RingdownOptions options;
    const auto stays = [&](double rate_per_s) {
        return watched([&](double t) { return std::exp(rate_per_s * t); }, options).stays();
    };
    EXPECT_FALSE(stays(0.0)); // it was not given the time to tell
    options.extension_s = 30.0;
    EXPECT_TRUE(stays(0.0));
    for (const double sign : {-1.0, 1.0}) {
        EXPECT_TRUE(stays(sign * 0.09 / 15.0)); // a tenth in half of the time
        EXPECT_FALSE(stays(sign * 0.11 / 15.0));
        EXPECT_FALSE(stays(sign * 10.0));
    }
    options.min_decay_per_s = 0.2;
    EXPECT_FALSE(stays(0.0)); // that is clear: not at rest
}

TEST(Ringdown, EndsWithWhatGoesRoundForEver) {
    RingdownOptions options;
    const auto bounded = [](double t) { return 1.0 - std::exp(-5.0 * t) * 0.9; };
    const auto samples = [&] {
        Ringdown ringdown(options, kPeriod_s);
        int k = 0;
        while (ringdown.watch(bounded(k * kPeriod_s))) {
            ++k;
        }
        EXPECT_FALSE(ringdown.dies_out());
        return k + 1;
    };
    EXPECT_EQ(samples(), 3000); // it might yet grow or fall
    options.min_decay_per_s = 0.2;
    // Within 2 % from 0.76 s on, which ten windows must be.
    EXPECT_NEAR(samples(), 1750, 150);
}

TEST(Ringdown, ADelayBeforeTheMotionDoesNotCount) {
    for (const double period_s : {1e-4, 1e-3, 5e-3, 0.02, 0.05}) {
        for (const int silent : {0, 1, 3, 8, 20}) {
            for (const double rate : {-2.0, 2.0}) {
                Ringdown ringdown({}, period_s);
                for (int k = 0; ringdown.watch(k < silent ? 0.0 : std::exp(rate * k * period_s));
                     ++k) {
                }
                EXPECT_EQ(ringdown.dies_out(), rate < 0.0)
                    << silent << " samples of " << period_s << " s, " << rate << "/s";
                EXPECT_NEAR(ringdown.growth_per_s(), rate, 1e-6);
            }
        }
    }
}

TEST(Ringdown, WhatNeverMovesIsAtRest) {
    Ringdown ringdown({}, kPeriod_s);
    int samples = 1;
    while (ringdown.watch(0.0)) {
        ++samples;
    }
    EXPECT_LE(samples, 3001);
    EXPECT_TRUE(ringdown.dies_out());
    EXPECT_EQ(ringdown.last(), 0.0);
}

} // namespace
} // namespace springdrive::rig
