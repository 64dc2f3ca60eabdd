// Covers engine/lab/rig/ringdown.{h,cpp}.
#include "engine/lab/rig/ringdown.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace springdrive::rig {
namespace {

constexpr double kPeriod_s = 1e-3;

/// A motion that was watched to its end, and for how many samples.
struct Watched {
    Ringdown ringdown;
    int samples = 0;
};

Watched watched(const std::function<double(double)> &motion, const RingdownOptions &options = {},
                double period_s = kPeriod_s) {
    Watched all{Ringdown(options, period_s)};
    while (all.ringdown.watch(std::abs(motion(all.samples++ * period_s)))) {
    }
    return all;
}

std::function<double(double)> exponential(double rate_per_s) {
    return [=](double time_s) { return std::exp(rate_per_s * time_s); };
}

double oscillation(double time_s, double rate_per_s, double frequency_hz) {
    return std::exp(rate_per_s * time_s) * std::cos(2.0 * M_PI * frequency_hz * time_s);
}

TEST(Ringdown, TellsGrowthFromDecayOnBothSidesOfZero) {
    for (const double rate : {30.0, 3.0, 0.3, 0.1}) {
        for (const double frequency : {0.0, 30.0, 170.0, 499.0}) {
            for (const double sign : {-1.0, 1.0}) {
                const auto motion = [&](double t) {
                    return oscillation(t, sign * rate, frequency);
                };
                EXPECT_EQ(watched(motion).ringdown.dies_out(), sign < 0.0)
                    << rate << "/s, " << frequency << " Hz";
            }
        }
    }
}

TEST(Ringdown, MeasuresTheRateOfAnOscillation) {
    for (const double rate : {-3.0, -0.5, 0.0, 0.5, 2.0}) {
        for (const double size : {1e-9, 1.0, 1e9}) {
            const auto motion = [&](double t) { return size * oscillation(t, rate, 60.0); };
            // The greatest of a window is found to a sample: 1 − cos(2π 60 Hz 0.5 ms), 2 %, of
            // which windows of whole turns have the same share; a second half of 1.5 s evens it.
            EXPECT_NEAR(watched(motion).ringdown.growth_per_s(), rate, 0.02) << size;
        }
    }
}

TEST(Ringdown, MeasuresTheRateAtAnyPeriodFromTheFirstMotionOn) {
    for (const double period_s : {1e-5, 1e-4, 1e-3, 5e-3, 0.0123, 0.05, 0.5}) {
        for (const int silent : {0, 1, 3, 8, 20}) {
            for (const double rate : {-0.7, 0.7}) {
                const auto motion = [&](double t) {
                    return t < (silent - 0.5) * period_s ? 0.0 : std::exp(rate * t);
                };
                const Ringdown ringdown = watched(motion, {}, period_s).ringdown;
                EXPECT_EQ(ringdown.dies_out(), rate < 0.0)
                    << silent << " samples of " << period_s << " s, " << rate << "/s";
                EXPECT_NEAR(ringdown.growth_per_s(), rate, 1e-6) << period_s << " s";
            }
        }
    }
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

TEST(Ringdown, JudgesMotionsOfOtherShapes) {
    RingdownOptions plain;
    RingdownOptions limited;
    limited.maximum = 100.0;
    RingdownOptions with_decay;
    with_decay.min_decay_per_s = 0.5;
    struct Case {
        const char *name;
        RingdownOptions options;
        std::function<double(double)> motion;
        bool dies_out;
    };
    // Up within a sample, then slowly down: in the end it decays.
    const auto peak = [](double height) {
        return [=](double t) { return t == 0.0 ? 1.0 : height * std::exp(-t); };
    };
    // More than a sample's factor of so much leaves the first window at once.
    const auto exploding = [](double per_sample) {
        return [=](double t) { return 1e-5 * std::pow(per_sample, t / kPeriod_s); };
    };
    const std::vector<Case> cases{
        {"at rest", plain, [](double) { return 0.0; }, true},
        {"burst", // to 500 times itself, then falls, as a linear loop with far poles may
         plain,
         [](double t) {
             return t < 0.3 ? std::exp(t / 0.3 * std::log(500.0))
                            : 500.0 * std::exp(-20.0 * (t - 0.3));
         },
         true},
        {"doubles each sample", plain, exploding(2.0), false},
        {"1e3 each sample", plain, exploding(1e3), false},
        {"1e200 each sample", plain, exploding(1e200), false},
        {"below the maximum", limited, peak(99.0), true},
        {"above the maximum", limited, peak(101.0), false},
        {"decays enough", with_decay, exponential(-0.6), true},
        {"decays too slowly", with_decay, exponential(-0.4), false},
        {"fast, but not to a half of its beginning", with_decay,
         [](double t) { return t < 1.6 ? 1.0 : std::exp(-0.45 * (t - 1.6)); }, false},
    };
    for (const Case &one : cases) {
        EXPECT_EQ(watched(one.motion, one.options).ringdown.dies_out(), one.dies_out) << one.name;
    }
    EXPECT_EQ(watched([](double) { return 0.0; }).ringdown.last(), 0.0);
}

TEST(Ringdown, WithPatienceTellsWhatIsSlow) {
    // Two motions, the one that grows hidden at first. After 30 s it is 20 times the other.
    RingdownOptions options;
    options.window_s = 0.3;
    for (const double grows_per_s : {0.06, 0.1}) {
        const auto dies_out = [&](double other_per_s) {
            return watched(
                       [=](double t) {
                           return oscillation(t, -0.12, 2.3) +
                                  0.1 * oscillation(t, other_per_s, 5.1);
                       },
                       options)
                .ringdown.dies_out();
        };
        options.extension_s = 0.0;
        EXPECT_TRUE(dies_out(grows_per_s));
        options.extension_s = 30.0;
        EXPECT_FALSE(dies_out(grows_per_s));
        EXPECT_TRUE(dies_out(-grows_per_s));
    }
}

TEST(Ringdown, EndsWhereThereIsNothingMoreToSee) {
    struct Case {
        double extension_s;
        double min_decay_per_s;
        double rate_per_s;
        double watched_s;
        double within_s;
    };
    for (const Case &one : {Case{0.0, 0.0, 0.0, 3.0, 1e-9}, // all of it
                            Case{0.0, 0.0, -100.0, 0.25, 0.25}, Case{0.0, 0.0, 100.0, 0.25, 0.25},
                            Case{30.0, 0.0, 0.0, 30.0, 1e-9}, Case{30.0, 0.0, -1.0, 3.0, 1e-9},
                            Case{30.0, 0.0, 1.0, 3.0, 1e-9},
                            // Half of 14 s at 0.1/s are a factor of two, half of 24 s one of
                            // three; a window more or two.
                            Case{30.0, 0.0, 0.1, 14.0, 0.3}, Case{30.0, 0.0, -0.1, 24.0, 0.3},
                            // With a least decay it is unclear while the motion falls.
                            Case{30.0, 0.2, -0.1, 3.0, 1e-9}, Case{30.0, 0.2, -0.4, 30.0, 1e-9}}) {
        RingdownOptions options;
        options.extension_s = one.extension_s;
        options.min_decay_per_s = one.min_decay_per_s;
        EXPECT_NEAR(watched(exponential(one.rate_per_s), options).samples * kPeriod_s,
                    one.watched_s, one.within_s)
            << one.rate_per_s << "/s";
    }
    EXPECT_LE(watched([](double) { return 0.0; }).samples, 3001);
    // A motion that goes round for ever might yet grow or fall, unless there is a least decay.
    RingdownOptions options;
    const auto bounded = [](double t) { return 1.0 - std::exp(-5.0 * t) * 0.9; };
    EXPECT_EQ(watched(bounded, options).samples, 3000);
    options.min_decay_per_s = 0.2;
    // Within 2 % from 0.76 s on, which ten windows must be.
    EXPECT_NEAR(watched(bounded, options).samples, 1750, 150);
    EXPECT_FALSE(watched(bounded, options).ringdown.dies_out());
}

TEST(Ringdown, WhatStaysIsNeitherSlowNorClear) {
    RingdownOptions options;
    const auto stays = [&](double rate_per_s) {
        return watched(exponential(rate_per_s), options).ringdown.stays();
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

TEST(QuantisationChatter, IsWhatGoesNoFartherForLongEnough) {
    constexpr double kLasting_s = 0.4;
    // When it is known to be all flicker [s]; infinite where not within 10 s.
    const auto known_after_s = [&](const std::function<Vector3(double)> &motion, double range_rad) {
        QuantisationChatter chatter(range_rad, kLasting_s, kPeriod_s);
        for (int k = 0; k < 10'000; ++k) {
            if (chatter.is_all()) {
                return k * kPeriod_s;
            }
            chatter.watch(motion(k * kPeriod_s));
        }
        return HUGE_VAL;
    };
    const auto swing = [](double amplitude_rad, double time_s) {
        return Vector3(amplitude_rad * std::cos(2.0 * M_PI * 40.0 * time_s) *
                       Vector3(0.3, -1.0, 0.5));
    };
    const Vector3 away(100.0, -3.0, 7.0);
    struct Case {
        const char *name;
        std::function<Vector3(double)> motion;
        double range_rad;
        double known_s;
        double within_s = 1e-9;
    };
    const std::vector<Case> cases{
        // To and fro is twice the amplitude.
        {"less", [&](double t) { return Vector3(away + swing(0.99, t)); }, 2.0, 0.4},
        {"more", [&](double t) { return swing(1.01, t); }, 2.0, HUGE_VAL},
        // e^(−5t) is 1/40 at 0.738 s; half a swing of 12.5 ms and a sample are the rest.
        {"dying", [&](double t) { return swing(40.0 * std::exp(-5.0 * t), t); }, 2.0, 0.738 + 0.4,
         0.015},
        {"leaps just before",
         [](double t) { return Vector3(5.0 * std::floor(t / 0.39 + 1e-6), 0.0, 0.0); }, 2.0,
         HUGE_VAL},
        {"leaps just after",
         [](double t) { return Vector3(5.0 * std::floor(t / 0.41 + 1e-6), 0.0, 0.0); }, 2.0, 0.4},
        {"still, without counts", [](double) { return Vector3(1.0, 2.0, 3.0); }, 0.0, 0.4},
        {"moving, without counts", [&](double t) { return swing(1e-9, t); }, 0.0, HUGE_VAL},
        {"no number", [](double) { return Vector3(0.0, NAN, 0.0); }, 2.0, HUGE_VAL},
    };
    for (const Case &one : cases) {
        const double known_s = known_after_s(one.motion, one.range_rad);
        if (std::isinf(one.known_s)) {
            EXPECT_EQ(known_s, HUGE_VAL) << one.name;
        } else {
            EXPECT_NEAR(known_s, one.known_s, one.within_s) << one.name;
        }
    }
}

TEST(QuantisationChatter, MayBeAllUntilItGoesTooFar) {
    QuantisationChatter chatter(2.0, 0.4, kPeriod_s);
    for (const auto &[angle_rad, may_be] :
         {std::pair{0.0, true}, {1.9, true}, {-0.2, false}, {-0.2, true}}) {
        chatter.watch(Vector3(0.0, angle_rad, 0.0));
        EXPECT_EQ(chatter.may_be_all(), may_be) << angle_rad;
    }
    EXPECT_FALSE(chatter.is_all());
}

} // namespace
} // namespace springdrive::rig
