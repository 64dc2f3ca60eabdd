// Covers device/core/motor/motor.cpp.
#include "device/core/motor/motor.h"

#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace springdrive::device {
namespace {

constexpr double kStep_s = 25e-6;
/// Round-off of currents of some amperes, amplified by the cancellation in a mean over a short
/// step.
constexpr double kRoundOff_A = 1e-12;

/// End and mean of i from L di/dt = V − R i, in closed form.
struct Current {
    double end_A = 0.0;
    double mean_A = 0.0;
};
Current closed_form(double voltage_V, double net_Ohm, double current_A, double step_s = kStep_s) {
    const double time_s = testing::phantom_motor().inductance_H / net_Ohm;
    const double steady_A = voltage_V / net_Ohm;
    const double decay = std::exp(-step_s / time_s);
    return {steady_A + (current_A - steady_A) * decay,
            steady_A + (current_A - steady_A) * (1.0 - decay) * time_s / step_s};
}

void expect_current(const CurrentStep &step, double rate_rad_per_s, const Current &truth) {
    EXPECT_NEAR(step.end_at(rate_rad_per_s), truth.end_A, kRoundOff_A);
    EXPECT_NEAR(step.mean_at(rate_rad_per_s), truth.mean_A, kRoundOff_A);
}

TEST(SpringDrive, IsAWindingOfTheResidualResistanceWithinItsLimits) {
    // (11): L di/dt = e_W − dR i − k_T θ̇, for any rotor velocity.
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> one(-1.0, 1.0);
    for (int i = 0; i < 1000; ++i) {
        const double R_Ohm = 2.18 * (1.0 + 0.3 * one(random));
        const double dR_Ohm = 1.1 + one(random);
        const DriveState now{R_Ohm, 1.5 * one(random), 100.0 * one(random), true};
        const double e_W_V = 3.0 * one(random);
        const double mean_rate = 100.0 * one(random);
        const CurrentStep step =
            spring_drive_step(testing::phantom_motor(), now, e_W_V, R_Ohm - dR_Ohm, kStep_s);
        expect_current(
            step, mean_rate,
            closed_form(e_W_V - testing::phantom_motor().torque_constant_Nm_per_A * mean_rate,
                        dR_Ohm, now.current_A));
    }
}

TEST(SpringDrive, IsLimitedToTheSupplyVoltage) {
    // e_A = R̂ i + e_W on either side of 12 V, and of −12 V.
    const double R_Ohm = testing::phantom_motor().resistance_Ohm;
    const double R_hat_Ohm = 1.7;
    for (const double sign : {1.0, -1.0}) {
        const DriveState now{R_Ohm, sign * 2.0, 0.0, true};
        const auto at = [&](double e_A_V) {
            const double e_W_V = sign * (e_A_V - R_hat_Ohm * 2.0);
            return spring_drive_step(testing::phantom_motor(), now, e_W_V, R_hat_Ohm, kStep_s);
        };
        const double supply_V = testing::phantom_motor().supply_V;
        expect_current(at(0.8 * supply_V), 0.0,
                       closed_form(sign * (0.8 * supply_V - R_hat_Ohm * 2.0), R_Ohm - R_hat_Ohm,
                                   now.current_A));
        // At the supply limit there is no cancellation: the full R, and at most 12 V.
        const Current railed = closed_form(sign * supply_V, R_Ohm, now.current_A);
        expect_current(at(1.001 * supply_V), 0.0, railed);
        expect_current(at(100.0 * supply_V), 0.0, railed);
    }
}

TEST(SpringDrive, ReachesTheSupplyVoltageWithinAStep) {
    // The current grows until R̂ i + e_W reaches the supply; that time has a closed form.
    const double R_Ohm = testing::phantom_motor().resistance_Ohm;
    const double R_hat_Ohm = 1.7;
    const double dR_Ohm = R_Ohm - R_hat_Ohm;
    for (const double share : {0.95, 0.99, 0.999}) {
        const DriveState now{R_Ohm, 2.0, 0.0, true};
        const double e_W_V = share * testing::phantom_motor().supply_V - R_hat_Ohm * now.current_A;
        const double steady_A = e_W_V / dR_Ohm;
        const double rail_A = (testing::phantom_motor().supply_V - e_W_V) / R_hat_Ohm;
        const double free_s = testing::phantom_motor().inductance_H / dR_Ohm *
                              std::log((now.current_A - steady_A) / (rail_A - steady_A));
        ASSERT_GT(free_s, 0.0);
        ASSERT_LT(free_s, kStep_s);
        const Current free = closed_form(e_W_V, dR_Ohm, now.current_A, free_s);
        const Current railed =
            closed_form(testing::phantom_motor().supply_V, R_Ohm, free.end_A, kStep_s - free_s);
        const double mean_A = (free_s * free.mean_A + (kStep_s - free_s) * railed.mean_A) / kStep_s;
        expect_current(spring_drive_step(testing::phantom_motor(), now, e_W_V, R_hat_Ohm, kStep_s),
                       0.0, {railed.end_A, mean_A});
    }
}

TEST(SpringDrive, DoesNotIncreaseACurrentAtItsLimit) {
    const MotorParameters m = testing::phantom_motor();
    const double supply_V = m.supply_V;
    const double sustaining_V = m.peak_current_A * m.resistance_Ohm; // 11.99 V, just below supply
    ASSERT_LT(sustaining_V, supply_V);
    for (const double sign : {1.0, -1.0}) {
        const auto step = [&](double current_A, double e_W_V) {
            return spring_drive_step(m, {m.resistance_Ohm, sign * current_A, 0.0, true},
                                     sign * e_W_V, 0.0, kStep_s);
        };
        const double below_A = m.peak_current_A * (1.0 - 1e-9);
        const double above_A = m.peak_current_A * 1.2;
        expect_current(step(below_A, supply_V), 0.0,
                       closed_form(sign * supply_V, m.resistance_Ohm, sign * below_A));
        expect_current(step(m.peak_current_A, supply_V), 0.0,
                       {sign * m.peak_current_A, sign * m.peak_current_A}); // stays
        expect_current(step(above_A, supply_V), 0.0,
                       closed_form(sign * sustaining_V, m.resistance_Ohm, sign * above_A));
        // A voltage that reduces the current is passed on.
        expect_current(step(above_A, -6.0), 0.0,
                       closed_form(-sign * 6.0, m.resistance_Ohm, sign * above_A));
    }
}

TEST(SpringDrive, HasNoLimitsWhenTheyAreOff) {
    const DriveState now{testing::phantom_motor().resistance_Ohm, 20.0, 0.0, false};
    expect_current(spring_drive_step(testing::phantom_motor(), now, 50.0, 0.0, kStep_s), 0.0,
                   closed_form(50.0, testing::phantom_motor().resistance_Ohm, 20.0));
}

TEST(CurrentDrive, FollowsAtItsBandwidth) {
    // di/dt = ω_b (i_commanded − i): after a millisecond of sub-steps as after one.
    constexpr double kBandwidth = 2.0 * std::numbers::pi * 200.0;
    double current_A = 0.3;
    double charge_C = 0.0;
    for (int k = 0; k < 40; ++k) {
        const CurrentStep step =
            current_drive_step(testing::phantom_motor(),
                               {testing::phantom_motor().resistance_Ohm, current_A, 20.0, true},
                               1.0, kBandwidth, kStep_s);
        charge_C += kStep_s * step.mean_at(20.0);
        current_A = step.end_at(20.0);
    }
    const double decay = std::exp(-kBandwidth * 1e-3);
    EXPECT_NEAR(current_A, 1.0 - 0.7 * decay, kRoundOff_A);
    EXPECT_NEAR(charge_C, 1e-3 - 0.7 * (1.0 - decay) / kBandwidth, kRoundOff_A * 1e-3);
    EXPECT_EQ(current_drive_step(testing::phantom_motor(), {2.18, 0.0, 0.0, true}, 1.0, kBandwidth,
                                 kStep_s)
                  .mean_As_per_rad,
              0.0); // independent of the rotor's velocity
}

TEST(CurrentDrive, IsLimitedToTheSupplyVoltage) {
    // At a constant 2 A the supply is exhausted at k_T θ̇ = 12 V − R · 2 A, a rotor at 327 rad/s.
    const MotorParameters m = testing::phantom_motor();
    const double spent_rad_per_s =
        (m.supply_V - 2.0 * m.resistance_Ohm) / m.torque_constant_Nm_per_A;
    const auto at = [&](double rate) {
        return current_drive_step(m, {m.resistance_Ohm, 2.0, rate, true}, 2.0, 1e4, kStep_s);
    };
    expect_current(at(0.999 * spent_rad_per_s), 0.0, {2.0, 2.0});
    const double too_fast = 1.1 * spent_rad_per_s;
    expect_current(
        at(too_fast), too_fast,
        closed_form(m.supply_V - m.torque_constant_Nm_per_A * too_fast, m.resistance_Ohm, 2.0));
    // A step that requires more than the winding's slope at 12 V, the fastest possible rise.
    const CurrentStep steep =
        current_drive_step(m, {m.resistance_Ohm, 0.0, 0.0, true}, 5.0, 1e5, kStep_s);
    expect_current(steep, 0.0, closed_form(m.supply_V, m.resistance_Ohm, 0.0));
}

TEST(CurrentDrive, HoldsItsCurrentLimitUnlessLimitsAreOff) {
    const double peak_A = testing::phantom_motor().peak_current_A;
    for (const double commanded_A : {0.9 * peak_A, 1.1 * peak_A, -1.1 * peak_A}) {
        const double held_A = std::clamp(commanded_A, -peak_A, peak_A);
        const DriveState now{2.0, held_A, 0.0, true};
        expect_current(current_drive_step(testing::phantom_motor(), now, commanded_A, 1e4, kStep_s),
                       0.0, {held_A, held_A});
    }
    const DriveState free{2.0, 20.0, 0.0, false};
    expect_current(current_drive_step(testing::phantom_motor(), free, 20.0, 1e4, kStep_s), 0.0,
                   {20.0, 20.0});
}

TEST(SpringDriveAtOnce, IsOhmsLawOnTheResidualResistance) {
    // (11) with L = 0: i = (e_W − k_T θ̇)/dR.
    const double R_Ohm = testing::phantom_motor().resistance_Ohm;
    for (const double dR_Ohm : {R_Ohm, 0.5, 0.02}) {
        for (const double rate : {0.0, 30.0, -30.0}) {
            const double current_A =
                (0.02 - testing::phantom_motor().torque_constant_Nm_per_A * rate) / dR_Ohm;
            const CurrentStep step = spring_drive_at_once(
                testing::phantom_motor(), {R_Ohm, 7.0, rate, false}, 0.02, R_Ohm - dR_Ohm);
            expect_current(step, rate, {current_A, current_A}); // independent of its previous value
        }
    }
}

TEST(SpringDriveAtOnce, IsTheLimitOfSmallInductance) {
    MotorParameters m = testing::phantom_motor();
    m.inductance_H *= 1e-9;
    const DriveState now{m.resistance_Ohm, 0.3, 5.0, false};
    const CurrentStep slow = spring_drive_step(m, now, 0.4, 1.6, kStep_s);
    const CurrentStep at_once = spring_drive_at_once(m, now, 0.4, 1.6);
    // The mean differs by 0.3 A times L/dR over the step, 4e-13 s of 25 µs.
    EXPECT_NEAR(slow.end_at(5.0), at_once.end_at(5.0), kRoundOff_A);
    EXPECT_NEAR(slow.mean_at(5.0), at_once.mean_at(5.0), 1e-7);
}

TEST(SpringDriveAtOnce, KeepsAResidualForAnOverCancelledWinding) {
    const double R_Ohm = testing::phantom_motor().resistance_Ohm;
    const double min_Ohm = kMinResidualShare * R_Ohm;
    for (const double cancelled_Ohm : {R_Ohm - min_Ohm, R_Ohm, R_Ohm + 0.1}) {
        const CurrentStep step = spring_drive_at_once(
            testing::phantom_motor(), {R_Ohm, 0.0, 0.0, false}, 1e-3, cancelled_Ohm);
        expect_current(step, 0.0, {1e-3 / min_Ohm, 1e-3 / min_Ohm});
    }
}

TEST(SpringDriveAtOnce, IsLimitedToTheSupplyVoltage) {
    // At standstill e_A = R̂ i + e_W = e_W R/dR. Nothing limits the current here.
    MotorParameters m = testing::phantom_motor();
    m.peak_current_A = 100.0;
    const double R_Ohm = m.resistance_Ohm;
    const double dR_Ohm = 0.5;
    const double max_V = m.supply_V * dR_Ohm / R_Ohm;
    const auto current_A = [&](double e_W_V) {
        return spring_drive_at_once(m, {R_Ohm, 0.0, 0.0, true}, e_W_V, R_Ohm - dR_Ohm).end_at(0.0);
    };
    EXPECT_NEAR(current_A(0.999 * max_V), 0.999 * m.supply_V / R_Ohm, kRoundOff_A);
    EXPECT_NEAR(current_A(1.001 * max_V), m.supply_V / R_Ohm, kRoundOff_A);
    EXPECT_NEAR(current_A(-3.0 * max_V), -m.supply_V / R_Ohm, kRoundOff_A);
}

TEST(SpringDriveAtOnce, HoldsItsCurrentLimit) {
    MotorParameters m = testing::phantom_motor();
    m.peak_current_A = 2.0;
    const double R_Ohm = m.resistance_Ohm;
    const auto current_A = [&](double wanted_A) {
        return spring_drive_at_once(m, {R_Ohm, 0.0, 0.0, true}, 0.5 * wanted_A, R_Ohm - 0.5)
            .end_at(0.0);
    };
    EXPECT_NEAR(current_A(1.999), 1.999, kRoundOff_A);
    EXPECT_NEAR(current_A(2.001), 2.0, kRoundOff_A);
    EXPECT_NEAR(current_A(-4.0), -2.0, kRoundOff_A);
}

TEST(CurrentDriveAtOnce, HoldsTheCommandWithinSupplyAndLimit) {
    const MotorParameters m = testing::phantom_motor();
    const double k_T = m.torque_constant_Nm_per_A;
    const double spent_rad_per_s = (m.supply_V - 2.0 * m.resistance_Ohm) / k_T;
    const auto at = [&](double commanded_A, double rate, bool limited) {
        return current_drive_at_once(m, {m.resistance_Ohm, 0.0, rate, limited}, commanded_A)
            .end_at(rate);
    };
    EXPECT_EQ(at(2.0, 0.999 * spent_rad_per_s, true), 2.0);
    const double too_fast = 1.1 * spent_rad_per_s;
    EXPECT_NEAR(at(2.0, too_fast, true), (m.supply_V - k_T * too_fast) / m.resistance_Ohm,
                kRoundOff_A);
    EXPECT_EQ(at(2.0, too_fast, false), 2.0);
    EXPECT_EQ(at(-1.1 * m.peak_current_A, 0.0, true), -m.peak_current_A);
    EXPECT_EQ(at(-1.1 * m.peak_current_A, 0.0, false), -1.1 * m.peak_current_A);
}

} // namespace
} // namespace springdrive::device
