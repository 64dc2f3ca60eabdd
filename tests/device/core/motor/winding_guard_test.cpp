// Covers device/core/motor/winding_heat.cpp.
#include "device/core/motor/winding_heat.h"

#include "engine/lab/rig/servo_rig.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace springdrive::device {
namespace {

constexpr double kPeriod_s = 1e-3;
constexpr double kAmplifierLimit_Ohm = 2.8;

WindingGuard guard(const MotorParameters &m) { return {m, kAmplifierLimit_Ohm, kPeriod_s}; }

/// The true winding: in each period its current approaches a new value as e^(−t/τ), and heats it in
/// ten parts of the period through the present R(T, θ).
struct TrueWinding {
    TrueWinding(const MotorParameters &parameters, double air_C)
        : m(parameters), temperature(parameters.thermal, air_C, kPeriod_s / 10) {}

    void run_to(double target_A) {
        for (int part = 0; part < 10; ++part) {
            const double before_A = current_A;
            current_A += (target_A - current_A) * 0.3;
            theta_rad += rate_rad_per_s * kPeriod_s / 10;
            const double mean_A2 =
                (before_A * before_A + before_A * current_A + current_A * current_A) / 3.0;
            temperature.update(mean_A2 *
                               winding_resistance_Ohm(m, temperature.winding_C(), theta_rad));
        }
    }

    MotorParameters m;
    WindingTemperature temperature;
    double current_A = 0.0;
    double theta_rad = 0.0;
    double rate_rad_per_s = 0.0;
};

/// Another R_wh, and the same copper behind it.
MotorParameters with_heat_path(MotorParameters motor, double factor) {
    motor.thermal.winding_housing_K_per_W *= factor;
    motor.thermal.winding_time_s *= factor;
    return motor;
}

TEST(WindingGuard, BoundsTheTrueTemperature) {
    const MotorParameters m = testing::phantom_motor();
    std::mt19937 random(3);
    std::uniform_real_distribution<double> share(-1.0, 1.0);
    for (int run = 0; run < 20; ++run) {
        const double air_C = 25.0 + 10.0 * share(random);
        const double heat_path = std::exp2(share(random));
        TrueWinding winding(with_heat_path(m, heat_path), air_C);
        winding.rate_rad_per_s = 100.0 * share(random);
        WindingGuard bounds = guard(m);
        double target_A = 0.0;
        for (int tick = 0; tick < 5000; ++tick) {
            if (tick % 250 == 0) { // sustained currents, sometimes with a jitter about zero
                target_A = 3.0 * share(random);
            }
            winding.run_to(tick % 1000 < 100 ? 0.5 * share(random) : target_A);
            bounds.update(winding.current_A);
            ASSERT_LE(bounds.min_C(), winding.temperature.winding_C());
            ASSERT_TRUE(heat_path > 1.0 || bounds.max_C() >= winding.temperature.winding_C());
        }
    }
}

// Heated for any time, then cooled for any time.
TEST(WindingGuard, NoHeatPathMakesAWindingColderThanTheBest) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> share(-1.0, 1.0);
    for (int run = 0; run < 200; ++run) {
        const MotorParameters m = testing::phantom_motor();
        WindingTemperature best(with_heat_path(m, 0.5).thermal, 25.0, 0.5);
        const double factor = std::exp2(share(random));
        WindingTemperature other(with_heat_path(m, factor).thermal, 25.0, 0.5);
        const double heated_s = std::exp(3.0 + 3.0 * share(random));
        for (int i = 0; i < 2000; ++i) {
            const double heat_W = 0.5 * i < heated_s ? 3.0 : 0.0;
            best.update(heat_W);
            other.update(heat_W);
            ASSERT_LE(best.winding_C(), other.winding_C() + 1e-9) << factor << ", " << heated_s;
        }
    }
}

TEST(WindingGuard, BoundsAreTightExceptForAirAndRipple) {
    // Without ripple, in the coldest air, with the best heat path and with a constant current, the
    // lower bound is exact.
    MotorParameters m = testing::phantom_motor();
    m.commutation_ripple = 0.0;
    TrueWinding winding(with_heat_path(m, 1.0 / kMaxHeatPathFactor), kColdestAir_C);
    WindingGuard bounds = guard(m);
    for (int tick = 0; tick < 20000; ++tick) {
        winding.run_to(1.5);
        bounds.update(winding.current_A);
    }
    EXPECT_GT(winding.temperature.winding_C(), 20.0); // not vacuous
    // The first tick, during which the current rises, adds no heat: 1.5² · 2.1 W · 1 ms into 3.9
    // J/K is 1.2 mK.
    EXPECT_NEAR(bounds.min_C(), winding.temperature.winding_C(), 2e-3);
}

TEST(WindingGuard, LeavesANetResistanceAtEveryAngleAfterAnyHistory) {
    // Warmed in the coldest air by a long or short current, then cooled: the allowed R̂ never
    // exceeds R at any angle, and the remaining share is the promised one.
    const MotorParameters m = testing::phantom_motor();
    for (const double current_A : {0.0, 0.5, 1.2, 3.0}) {
        TrueWinding winding(m, kColdestAir_C);
        WindingGuard bounds = guard(m);
        for (int tick = 0; tick < 60000; ++tick) {
            winding.run_to(tick < 20000 ? current_A : 0.0);
            bounds.update(winding.current_A);
            const double min_Ohm = min_resistance_Ohm(m, winding.temperature.winding_C());
            ASSERT_LT(bounds.max_cancelled_Ohm(), min_Ohm);
        }
    }
    const double coldest_Ohm = min_resistance_Ohm(m, kColdestAir_C);
    EXPECT_DOUBLE_EQ(guard(m).max_cancelled_Ohm(), (1.0 - kMinResidualShare) * coldest_Ohm);
}

TEST(WindingGuard, AllowsWarmMotorsMoreUntilTheyCool) {
    const MotorParameters m = testing::phantom_motor();
    WindingGuard bounds = guard(m);
    const double cold_Ohm = bounds.max_cancelled_Ohm();
    for (int tick = 0; tick < 30000; ++tick) {
        bounds.update(2.0);
    }
    const double hot_Ohm = bounds.max_cancelled_Ohm();
    // 0.39 %/K of the certain temperature rise.
    const double warmed_K = bounds.min_C() - kColdestAir_C;
    EXPECT_GT(warmed_K, 15.0);
    EXPECT_NEAR(hot_Ohm - cold_Ohm, (1.0 - kMinResidualShare) * 0.98 * 2.18 * 0.0039 * warmed_K,
                1e-12);
    double before_Ohm = hot_Ohm;
    bounds.update(0.0);
    for (int tick = 0; tick < 60000; ++tick) {
        bounds.update(0.0);
        ASSERT_LT(bounds.max_cancelled_Ohm(), before_Ohm);
        before_Ohm = bounds.max_cancelled_Ohm();
    }
}

TEST(WindingGuard, NeverExceedsTheAmplifiersLimit) {
    const MotorParameters m = testing::phantom_motor();
    const double cold_Ohm = guard(m).max_cancelled_Ohm();
    EXPECT_DOUBLE_EQ(WindingGuard(m, 1.001 * cold_Ohm, kPeriod_s).max_cancelled_Ohm(), cold_Ohm);
    EXPECT_DOUBLE_EQ(WindingGuard(m, 0.999 * cold_Ohm, kPeriod_s).max_cancelled_Ohm(),
                     0.999 * cold_Ohm);
}

TEST(WindingGuard, KeepsAColdDeviceWithTooSmallAResidualStable) {
    // The whole servo on the simulated device in the coldest air: dR = 0.02 Ω at 25 °C is negative
    // at 15 °C. The hand moves, so that the commutators turn.
    simulated::SimulationOptions options;
    options.ambient_C = kColdestAir_C;
    options.path.emplace(std::vector<simulated::HandPath::Point>{
        {0.0, Vector3(0, 0.02, 0)}, {1.2, Vector3(0, 0.02, 0)}, {2.1, Vector3(0.03, 0.05, 0.02)}});
    rig::ServoRig rig(testing::phantom_1_0(), options, Vector3(0, 0.02, 0));
    rig.inputs.tuning.dR_Ohm = 0.02;
    const double requested_Ohm = testing::phantom_motor().resistance_Ohm - rig.inputs.tuning.dR_Ohm;
    int over_cancelled_without = 0;
    for (int tick = 0; tick < 2100; ++tick) {
        const servo::ServoSample &sample = rig.tick();
        ASSERT_NE(sample.safety.state, servo::SafetyState::tripped)
            << servo::description(sample.safety);
        const Vector3 &R_Ohm = rig.truth().resistance_Ohm;
        const Vector3 dR_Ohm = R_Ohm - sample.command.cancelled_resistance_Ohm;
        ASSERT_GT(dR_Ohm.minCoeff(), 0.0);
        ASSERT_TRUE(sample.winding[0].is_limited || tick < 1110); // once it has ramped up
        over_cancelled_without += tick >= 1110 && requested_Ohm > R_Ohm.minCoeff() ? 1 : 0;
    }
    EXPECT_GT(over_cancelled_without, 900);
}

TEST(WindingGuard, AnUnknownCurrentWidensTheBounds) {
    const MotorParameters m = testing::phantom_motor();
    for (const double unknown : {static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
        WindingGuard idle = guard(m);
        WindingGuard full = guard(m);
        WindingGuard blind = guard(m);
        full.update(m.peak_current_A);
        idle.update(0.0);
        blind.update(unknown);
        // One end of the next tick is still unknown.
        full.update(m.peak_current_A);
        idle.update(0.0);
        blind.update(1.0);
        EXPECT_EQ(blind.min_C(), idle.min_C());
        EXPECT_EQ(blind.max_C(), full.max_C());
        blind.update(1.0);
        EXPECT_GT(blind.min_C(), kColdestAir_C);
    }
}

TEST(WindingGuard, StartsFromTheTolerance) {
    const MotorParameters m = testing::phantom_motor();
    MotorParameters least = m;
    least.resistance_Ohm *= 0.94;
    const WindingGuard tolerant(m, kAmplifierLimit_Ohm, kPeriod_s, 0.06);
    EXPECT_NEAR(tolerant.max_cancelled_Ohm(),
                (1.0 - kMinResidualShare) * min_resistance_Ohm(least, kColdestAir_C), 1e-15);
    // The upper bound of the temperature counts the heat of the largest R.
    MotorParameters most = m;
    most.resistance_Ohm *= 1.06;
    WindingGuard hot = tolerant;
    WindingGuard of_most = guard(most);
    for (int tick = 0; tick < 1000; ++tick) {
        hot.update(2.0);
        of_most.update(2.0);
    }
    EXPECT_EQ(hot.max_C(), of_most.max_C());
}

// Brushes and bridge look like a resistance to an observer, so that its R may be too large.
TEST(WindingGuard, AnObservationAllowsNoMore) {
    const MotorParameters m = testing::phantom_motor();
    for (const double R_Ohm : {2.05, 2.18, 2.35}) {
        WindingGuard bounds(m, kAmplifierLimit_Ohm, kPeriod_s, 0.06);
        WindingGuard unobserved = bounds;
        for (int tick = 0; tick < 2000; ++tick) {
            bounds.narrow({R_Ohm - 0.03, R_Ohm + 0.03});
            bounds.update(1.0);
            unobserved.update(1.0);
            ASSERT_EQ(bounds.max_cancelled_Ohm(), unobserved.max_cancelled_Ohm());
        }
        EXPECT_FALSE(bounds.is_contradicted());
    }
}

TEST(WindingGuard, AnObservationThatContradictsAnotherEndsAll) {
    const MotorParameters m = testing::phantom_motor();
    const double margins_Ohm = 2.0 * 0.01 * m.resistance_Ohm;
    for (const double gap_Ohm : {0.99 * margins_Ohm, 1.01 * margins_Ohm}) {
        for (const double side : {-1.0, 1.0}) {
            WindingGuard bounds(m, kAmplifierLimit_Ohm, kPeriod_s, 0.06);
            bounds.narrow({2.2, 2.2});
            bounds.narrow({2.2 + side * gap_Ohm, 2.2 + side * gap_Ohm});
            EXPECT_EQ(bounds.is_contradicted(), gap_Ohm > margins_Ohm);
            if (bounds.is_contradicted()) {
                bounds.narrow({2.2, 2.2});
                EXPECT_TRUE(bounds.is_contradicted());
                bounds.forget_observations();
                bounds.narrow({2.2, 2.2});
                EXPECT_FALSE(bounds.is_contradicted());
            }
        }
    }
    // R may be 6 % from the file's, in air 10 K colder or warmer than its temperature.
    for (const double R_Ohm : {2.18 * 0.94 * (1.0 - 0.039), 2.18 * 1.06 * (1.0 + 0.039)}) {
        for (const double outward_Ohm : {-1e-6, 1e-6}) {
            WindingGuard bounds(m, kAmplifierLimit_Ohm, kPeriod_s, 0.06);
            const double side = R_Ohm < 2.18 ? -1.0 : 1.0;
            const double seen_Ohm = R_Ohm + side * (0.5 * margins_Ohm + outward_Ohm);
            bounds.narrow({seen_Ohm, seen_Ohm});
            EXPECT_EQ(bounds.is_contradicted(), outward_Ohm > 0.0) << R_Ohm;
        }
    }
    WindingGuard bounds(m, kAmplifierLimit_Ohm, kPeriod_s, 0.06);
    bounds.narrow({NAN, NAN});
    EXPECT_TRUE(bounds.is_contradicted());
}

// Half a kelvin a minute is followed; ten kelvins at once are a contradiction.
TEST(WindingGuard, AnObservationAges) {
    const MotorParameters m = testing::phantom_motor();
    WindingGuard bounds(m, kAmplifierLimit_Ohm, kPeriod_s, 0.06);
    double R_Ohm = 2.1;
    for (int second = 0; second < 1200; ++second) {
        bounds.narrow({R_Ohm - 0.005, R_Ohm + 0.005});
        ASSERT_FALSE(bounds.is_contradicted()) << second;
        R_Ohm += 2.18 * 0.0039 * 0.5 / 60.0;
        for (int tick = 0; tick < 1000; ++tick) {
            bounds.update(0.0);
        }
    }
    bounds.narrow({R_Ohm + 0.08, R_Ohm + 0.09});
    EXPECT_TRUE(bounds.is_contradicted());
}

TEST(WindingGuard, MissedPeriodsWarmAndCoolToo) {
    // Over each gap the upper bound assumes the current in every period, the lower bound in none.
    const DeviceDescription device = testing::phantom_1_0();
    const MotorParameters &motor = device.motor[0];
    const double amplifier_Ohm = device.amplifier.max_cancelled_Ohm;
    for (const std::uint32_t missed : {1U, 7U, 100U, 101U, 1000U}) {
        WindingGuard guard(motor, amplifier_Ohm, 1e-3);
        WindingGuard every(motor, amplifier_Ohm, 1e-3);
        for (int i = 0; i < 5000; ++i) {
            guard.update(3.0);
            every.update(3.0);
        }
        WindingGuard on_time = guard;
        on_time.update(3.0);
        guard.update(3.0, missed);
        EXPECT_LT(guard.min_C(), on_time.min_C()) << missed;
        EXPECT_GE(guard.min_C(), kColdestAir_C) << missed;
        EXPECT_EQ(guard.min_C() < kColdestAir_C + 0.1, missed > 100) << missed; // a long gap
        for (std::uint32_t i = 0; i < missed + 1; ++i) {
            every.update(3.0);
        }
        // At once; over a long gap with the R of a winding at its limit, up to 0.7 Ω more.
        EXPECT_GE(guard.max_C(), every.max_C() - 1e-9) << missed;
        const double more_K = missed > 100 ? 1e-3 * missed * 9.0 * 0.7 / 3.87 : 1e-9;
        EXPECT_LE(guard.max_C(), every.max_C() + more_K) << missed;
    }
}

} // namespace
} // namespace springdrive::device
