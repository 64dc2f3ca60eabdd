// Covers what the safety monitor consists of: of safety_monitor.h the energy observer and the
// detector of rest; safety_limits.cpp and safety_status.cpp.
#include "engine/servo/safety_monitor.h"

#include "device/core/haptic_device.h"
#include "engine/servo/safety_limits.h"
#include "engine/servo/safety_status.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <random>
#include <set>
#include <string>

namespace springdrive::servo {
namespace {

constexpr double kObserverPeriod_s = 1e-3;
constexpr double kLimit_J = 0.03;
constexpr double kForgetsNothing_s = 1e-15; ///< a period too short for any decay

/// The coupling: F = −K d, d from the proxy to the tip; stored energy ½ K d².
struct Spring {
    double stiffness_N_per_m = 1000.0;

    [[nodiscard]] Vector3 force_N(const Vector3 &tip_m) const { return -stiffness_N_per_m * tip_m; }
    [[nodiscard]] double stored_J(const Vector3 &tip_m) const {
        return spring_energy_J(force_N(tip_m), -tip_m, 1.0);
    }
};

void go(EnergyObserver &observer, const Spring &spring, const Vector3 &tip_m) {
    observer.update(tip_m, spring.force_N(tip_m), spring.stored_J(tip_m), 0.0, kLimit_J);
}

TEST(EnergyObserver, AnExactSpringGeneratesNothing) {
    // The trapezoidal rule is exact for a force that is linear in the displacement, for any step.
    std::mt19937_64 random(1);
    for (int run = 0; run < 100; ++run) {
        EnergyObserver observer(kObserverPeriod_s);
        const Spring spring{std::uniform_real_distribution<double>(100.0, 5000.0)(random)};
        const Vector3 first_m = testing::random_vector(random, 5e-3);
        go(observer, spring, first_m);
        for (int tick = 0; tick < 1000; ++tick) {
            go(observer, spring, testing::random_vector(random, 5e-3));
            ASSERT_LT(std::abs(observer.generated_J()), 1e-13); // of about 0.1 J exchanged
        }
        go(observer, spring, first_m);
        ASSERT_LT(std::abs(observer.generated_J()), 1e-13);
    }
}

TEST(EnergyObserver, ASpringThatIsStifferOnTheWayOutGeneratesTheSurplus) {
    // In against K, out against K + ΔK: the hand receives ½ ΔK d² of generated energy, counted once
    // all that it put in is returned. No decay meanwhile.
    const double depth_m = 5e-3;
    const Spring in{1000.0};
    const Spring out{1200.0};
    const double surplus_J = 0.5 * 200.0 * depth_m * depth_m;
    EnergyObserver observer(kForgetsNothing_s);
    constexpr int kSteps = 50;
    for (int step = 0; step <= kSteps; ++step) {
        go(observer, in, Vector3(0.0, -depth_m * step / kSteps, 0.0));
        EXPECT_NEAR(observer.generated_J(), 0.0, 1e-13);
    }
    for (int step = kSteps; step >= 0; --step) {
        const double left_m = depth_m * step / kSteps;
        go(observer, out, Vector3(0.0, -left_m, 0.0));
        const double got_J = 0.5 * 1200.0 * (depth_m * depth_m - left_m * left_m);
        const double put_in_J = 0.5 * 1000.0 * depth_m * depth_m;
        EXPECT_NEAR(observer.generated_J(), std::max(0.0, got_J - put_in_J), 1e-13);
    }
    EXPECT_NEAR(observer.generated_J(), surplus_J, 1e-13);
}

TEST(EnergyObserver, ForceBeyondTheSpringGeneratesTheSurplus) {
    // The law's spring is K throughout; the rendered force is that of K on the way in, and stiffer
    // on the way out, as caused by a lag. Over a closed path ½ ΔK d² is generated.
    const double depth_m = 5e-3;
    const Spring law{1000.0};
    for (const double surplus_N_per_m : {0.0, 100.0, 400.0}) {
        const Spring out{law.stiffness_N_per_m + surplus_N_per_m};
        EnergyObserver observer(kForgetsNothing_s);
        constexpr int kSteps = 50;
        for (int step = 0; step <= kSteps; ++step) {
            go(observer, law, Vector3(0.0, -depth_m * step / kSteps, 0.0));
        }
        for (int step = kSteps; step >= 0; --step) {
            const Vector3 tip_m(0.0, -depth_m * step / kSteps, 0.0);
            observer.update(tip_m, out.force_N(tip_m), law.stored_J(tip_m), 0.0, kLimit_J);
        }
        EXPECT_NEAR(observer.generated_J(), 0.5 * surplus_N_per_m * depth_m * depth_m, 1e-13);
    }
}

TEST(EnergyObserver, ADamperOnlyDissipates) {
    // F = −b v: G decreases by the dissipated energy, −Σ F Δx, down to its lower bound.
    EnergyObserver observer(kForgetsNothing_s);
    double taken_J = 0.0;
    const double force_N = -2.0;
    observer.update(Vector3::Zero(), Vector3(force_N, 0, 0), 0.0, 0.0, kLimit_J);
    for (int tick = 1; tick <= 100; ++tick) {
        observer.update(Vector3(1e-4 * tick, 0, 0), Vector3(force_N, 0, 0), 0.0, 0.0, kLimit_J);
        taken_J += 2.0 * 1e-4;
        EXPECT_NEAR(observer.generated_J(), -taken_J, 1e-13);
    }
}

TEST(EnergyObserver, DecaysWithItsTimeConstantAtAnyRate) {
    for (const double period_s : {1.0 / 250, 1e-3, 1e-4}) {
        EnergyObserver observer(period_s);
        const Vector3 push_N(1.0, 0, 0);
        observer.update(Vector3::Zero(), push_N, 0.0, 0.0, kLimit_J);
        observer.update(Vector3(0.01, 0, 0), push_N, 0.0, 0.0, kLimit_J);
        const double made_J = observer.generated_J();
        EXPECT_NEAR(made_J, 0.01, 1e-15);
        const int ticks = static_cast<int>(std::lround(0.7 / period_s));
        for (int tick = 0; tick < ticks; ++tick) {
            observer.update(Vector3(0.01, 0, 0), Vector3::Zero(), 0.0, 0.0, kLimit_J);
        }
        EXPECT_NEAR(observer.generated_J(), made_J * std::exp(-0.7 / 0.5), 1e-10);
    }
}

TEST(EnergyObserver, CreditIsBounded) {
    // Regardless of the energy put in before, at most twice the limit can be returned.
    EnergyObserver observer(kForgetsNothing_s);
    Vector3 tip_m = Vector3::Zero();
    const auto move = [&](double force_N, double way_m) {
        observer.update(tip_m, Vector3(force_N, 0, 0), 0.0, 0.0, kLimit_J);
        tip_m.x() += way_m;
        observer.update(tip_m, Vector3(force_N, 0, 0), 0.0, 0.0, kLimit_J);
    };
    for (int i = 0; i < 100; ++i) {
        move(-5.0, 0.01);
        ASSERT_GE(observer.generated_J(), -kLimit_J);
    }
    EXPECT_EQ(observer.generated_J(), -kLimit_J);
    move(5.0, 1.99 * kLimit_J / 5.0);
    EXPECT_NEAR(observer.generated_J(), 0.99 * kLimit_J, 1e-15);
    move(5.0, 0.02 * kLimit_J / 5.0);
    EXPECT_GT(observer.generated_J(), kLimit_J);
}

TEST(EnergyObserver, AChangeOfTheSpringIsNotCounted) {
    // Stiffened at 5 mm and then released: 25 mJ more come out than went in, supplied by the
    // operator's change of tuning; any further energy is counted.
    const double depth_m = 5e-3;
    for (const bool told : {false, true}) {
        EnergyObserver observer(kForgetsNothing_s);
        const Spring soft{1000.0};
        const Spring stiff{3000.0};
        const Vector3 pressed_m(0.0, -depth_m, 0.0);
        go(observer, soft, pressed_m);
        const double more_J = stiff.stored_J(pressed_m) - soft.stored_J(pressed_m);
        observer.update(pressed_m, stiff.force_N(pressed_m), stiff.stored_J(pressed_m),
                        told ? more_J : 0.0, kLimit_J);
        EXPECT_EQ(observer.generated_J(), 0.0);
        for (int step = 50; step >= 0; --step) {
            go(observer, stiff, pressed_m * step / 50.0);
        }
        EXPECT_NEAR(observer.generated_J(), told ? 0.0 : 0.025, 1e-13);
    }
}

TEST(EnergyObserver, AnOverestimatedSpringCausesNoFalseAlarm) {
    // The model has twice the stiffness of the force, in and out: nothing is generated.
    EnergyObserver observer(kForgetsNothing_s);
    const Spring force{1000.0};
    const Spring model{2000.0};
    double max_J = 0.0;
    for (int turn = 0; turn < 20; ++turn) {
        for (int step = 0; step <= 100; ++step) {
            const double share = std::sin(std::numbers::pi * step / 100);
            const Vector3 tip_m(0.0, -5e-3 * share, 0.0);
            observer.update(tip_m, force.force_N(tip_m), model.stored_J(tip_m), 0.0, kLimit_J);
            max_J = std::max(max_J, observer.generated_J());
        }
    }
    EXPECT_LT(max_J, 1e-13);
}

TEST(EnergyObserver, RestartsAfterAReset) {
    EnergyObserver observer(kObserverPeriod_s);
    const Vector3 push_N(1.0, 0, 0);
    observer.update(Vector3::Zero(), push_N, 0.0, 0.0, kLimit_J);
    observer.update(Vector3(0.01, 0, 0), push_N, 0.0, 0.0, kLimit_J);
    observer.reset();
    EXPECT_EQ(observer.generated_J(), 0.0);
    observer.update(Vector3(1.0, 0, 0), push_N, 5.0, 0.0, kLimit_J); // no displacement from the
                                                                     // previous position
    EXPECT_EQ(observer.generated_J(), 0.0);
}

TEST(EnergyObserver, ALimitedSpringStoresTheWorkOfStretchingIt) {
    // Compared with the integral of min(K x, share K d) over the displacement, in fine steps.
    const double K_N_per_m = 1500.0;
    const double depth_m = 4e-3;
    for (const double share : {0.0, 0.1, 0.5, 0.9, 1.0}) {
        constexpr int kSteps = 20'000;
        double integral_J = 0.0;
        for (int i = 0; i < kSteps; ++i) {
            const double x_m = depth_m * (i + 0.5) / kSteps;
            integral_J += std::min(K_N_per_m * x_m, share * K_N_per_m * depth_m) * depth_m / kSteps;
        }
        const Vector3 stretch_m(0.0, depth_m, 0.0);
        EXPECT_NEAR(spring_energy_J(K_N_per_m * stretch_m, stretch_m, share), integral_J, 1e-9);
    }
}

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

int ticks_to_rest_in_place(RestDetector &watch, double period_s = kWatchPeriod_s) {
    return ticks_to_rest(
        watch, [](int) { return kPlace_m; }, period_s);
}

TEST(RestDetector, NeedsATenthOfASecondInOnePlaceAtAnyRate) {
    for (const double rate_hz : {250.0, 1000.0, 3000.0, 10'000.0}) {
        RestDetector watch(1.0 / rate_hz);
        const int ticks = ticks_to_rest_in_place(watch, 1.0 / rate_hz);
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
    EXPECT_GT(ticks_to_rest_in_place(watch), 99);
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
        EXPECT_GT(ticks_to_rest_in_place(watch),
                  0); // it recovers
    }
}

TEST(RestDetector, AResetRestartsTheTime) {
    RestDetector watch(kWatchPeriod_s);
    ASSERT_GT(ticks_to_rest_in_place(watch), 0);
    watch.reset();
    EXPECT_FALSE(watch.is_at_rest());
    EXPECT_GE(ticks_to_rest_in_place(watch), 100);
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

void expect_equal(const SafetyLimits &a, const SafetyLimits &b) {
    for (const SafetyLimit &limit : kSafetyLimits) {
        EXPECT_EQ(a.*limit.value, b.*limit.value) << limit.name;
    }
}

TEST(SafetyLimits, AreThoseOfTheDeviceFile) {
    const SafetyLimits limits = limits_of(testing::phantom_1_0());
    EXPECT_EQ(limits.voltage_V, 12.0);
    EXPECT_EQ(limits.current_A, 5.5);
    EXPECT_EQ(limits.winding_C, 100.0);
    EXPECT_EQ(limits.tip_force_N, 8.5);
    EXPECT_EQ(limits.tip_speed_m_per_s, 2.0);
    EXPECT_NEAR(limits.beyond_stops_rad, 3.0 * 3.141592653589793 / 180.0, 1e-15);
    EXPECT_EQ(limits.generated_energy_J, 0.03);
    EXPECT_DOUBLE_EQ(limits.late_s, 0.05);
    EXPECT_DOUBLE_EQ(limits.stale_s, 0.005);
    EXPECT_EQ(limits.window_silence_s, 2.0);
}

TEST(SafetyLimits, TheLargestLimitCountsForUnequalMotors) {
    device::DeviceDescription device = testing::phantom_1_0();
    device.motor[1].supply_V = 24.0;
    device.motor[2].peak_current_A = 9.0;
    device.motor[0].thermal.max_winding_C = 155.0;
    const SafetyLimits limits = limits_of(device);
    EXPECT_EQ(limits.voltage_V, 24.0);
    EXPECT_EQ(limits.current_A, 9.0);
    EXPECT_EQ(limits.winding_C, 155.0);
}

TEST(SafetyLimits, TheListNamesEveryFieldOnce) {
    // Every double of the struct, each once.
    EXPECT_EQ(sizeof(SafetyLimits), kSafetyLimits.size() * sizeof(double));
    SafetyLimits counted;
    double number = 0.0;
    for (const SafetyLimit &limit : kSafetyLimits) {
        counted.*limit.value = ++number;
    }
    std::set<std::string> names;
    number = 0.0;
    for (const SafetyLimit &limit : kSafetyLimits) {
        EXPECT_EQ(counted.*limit.value, ++number) << limit.name;
        EXPECT_TRUE(names.insert(limit.name).second);
        EXPECT_GT(limit.shown_per_si, 0.0);
    }
}

TEST(SafetyLimits, LoweringOneLimitChangesNoOther) {
    const SafetyLimits device = limits_of(testing::phantom_1_0());
    for (const SafetyLimit &changed : kSafetyLimits) {
        for (const double share : {1e-3, 0.5, 0.999}) {
            SafetyLimits request = unlowered();
            request.*changed.value = share * (device.*changed.value);
            SafetyLimits expected = device;
            expected.*changed.value = share * (device.*changed.value);
            expect_equal(lowered(device, request), expected);
        }
    }
}

TEST(SafetyLimits, NoneCanBeRaised) {
    const SafetyLimits device = limits_of(testing::phantom_1_0());
    for (const SafetyLimit &changed : kSafetyLimits) {
        for (const double share : {1.0, 1.001, 1e6}) {
            SafetyLimits request = unlowered();
            request.*changed.value = share * (device.*changed.value);
            expect_equal(lowered(device, request), device);
        }
    }
}

TEST(SafetyLimits, InvalidRequestsChangeNothing) {
    const SafetyLimits device = limits_of(testing::phantom_1_0());
    expect_equal(lowered(device, unlowered()), device);
    for (const SafetyLimit &changed : kSafetyLimits) {
        for (const double requested : {kNaN, -kNaN, 0.0, -0.0, -1.0, -kInfinity, kInfinity}) {
            SafetyLimits request = unlowered();
            request.*changed.value = requested;
            expect_equal(lowered(device, request), device);
        }
    }
}

std::string told(TripCause cause, double measured = 0.0, double limit = 0.0) {
    return description({SafetyState::tripped, cause, measured, limit, 0.0, {}, 0});
}

TEST(SafetyStatus, DescribesTheExceededLimitInDisplayUnits) {
    EXPECT_EQ(told(TripCause::current, 5.568, 5.5), "winding current 5.57 A, limit 5.50 A");
    EXPECT_EQ(told(TripCause::tip_force, 9.0, 8.5), "tip force 9.00 N, limit 8.50 N");
    EXPECT_EQ(told(TripCause::tip_speed, 2.5, 2.0), "tip speed 2.50 m/s, limit 2.00 m/s");
    EXPECT_EQ(told(TripCause::winding_temperature, 100.26, 100.0),
              "winding temperature, upper estimate, 100.3 °C, limit 100.0 °C");
    EXPECT_EQ(told(TripCause::missed_deadlines, 0.051, 0.05),
              "consecutive deadlines missed for 51.0 ms, limit 50.0 ms");
    EXPECT_EQ(told(TripCause::window_silent, 2.001, 2.0),
              "no heartbeat from the window for 2.00 s, limit 2.00 s");
    EXPECT_EQ(told(TripCause::encoder_jump, 0.0123, 0.004),
              "encoder jump at the tip 12.30 mm, limit 4.00 mm");
    EXPECT_EQ(told(TripCause::beyond_stops, 0.0698131700797732, 0.0523598775598299),
              "joint angle beyond its stop by 4.0°, limit 3.0°");
    EXPECT_EQ(told(TripCause::energy, 0.0312, 0.03),
              "energy delivered to the hand 31.2 mJ, limit 30.0 mJ");
    EXPECT_EQ(told(TripCause::voltage, 13.5, 12.0), "sustained e_W 13.5 V, limit 12.0 V");
}

TEST(SafetyStatus, EveryCauseHasItsOwnNameAndText) {
    ASSERT_EQ(kTripCauseNames.size(), static_cast<std::size_t>(TripCause::motor_contradicted) + 1);
    std::set<std::string> names;
    std::set<std::string> words;
    for (std::size_t i = 0; i < kTripCauseNames.size(); ++i) {
        EXPECT_TRUE(names.insert(std::string(kTripCauseNames[i])).second);
        const std::string text = told(static_cast<TripCause>(i), 1.0, 2.0);
        EXPECT_NE(text, "unknown") << i;
        EXPECT_EQ(text.find('\n'), std::string::npos);
        EXPECT_TRUE(words.insert(text).second) << text;
    }
    EXPECT_EQ(kTripCauseNames[static_cast<std::size_t>(TripCause::torn_inputs)], "torn_inputs");
    EXPECT_EQ(kTripCauseNames[static_cast<std::size_t>(TripCause::current)], "current");
    EXPECT_EQ(kTripCauseNames[static_cast<std::size_t>(TripCause::voltage)], "voltage");
    EXPECT_EQ(kTripCauseNames[static_cast<std::size_t>(TripCause::assertion)], "assertion");
}

TEST(SafetyStatus, SaysThatARequestedStopIsHeldWhateverTrippedFirst) {
    SafetyStatus status{SafetyState::tripped, TripCause::tip_speed, 2.5, 2.0, 0.0, {}, 3};
    EXPECT_EQ(description(status),
              "tip speed 2.50 m/s, limit 2.00 m/s; then it was stopped by hand");
    status.cause = TripCause::emergency_stop;
    EXPECT_EQ(description(status), "emergency stop");
    status.cause = TripCause::board_fault;
    status.measured = device::BoardFaults::kStop;
    EXPECT_EQ(description(status).find("hand"), std::string::npos);
}

TEST(SafetyStatus, DescribesNaNAndHugeNumbers) {
    EXPECT_EQ(told(TripCause::tip_force, 1e300, 8.5).find("tip force 1000000"), 0U);
    EXPECT_NE(told(TripCause::tip_force, std::numeric_limits<double>::quiet_NaN(), 8.5).find("nan"),
              std::string::npos);
}

} // namespace
} // namespace springdrive::servo
