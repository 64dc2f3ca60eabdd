// Covers engine/lab/loops/rendered_stiffness.cpp.
#include "engine/lab/loops/rendered_stiffness.h"

#include "engine/control/coupling.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace springdrive::loops {
namespace {

using Complex = std::complex<double>;

/// The tunings that the panels allow.
SpringDrive random_drive(std::mt19937 &random) {
    const auto between = [&random](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    SpringDrive drive;
    drive.motor = testing::phantom_1_0().motor[0];
    drive.tuning.dR_Ohm = std::exp(between(std::log(0.02), std::log(2.0)));
    drive.tuning.K_P_V_per_rad = between(0.5, 500.0);
    drive.tuning.K_D_Vs_per_rad = between(0.0, 1.0);
    drive.tuning.lambda_rad_per_s = std::exp(between(std::log(100.0), std::log(5000.0)));
    drive.period_s = 1.0 / between(500.0, 10000.0);
    drive.delay_periods = std::uniform_int_distribution<int>(0, 2)(random);
    return drive;
}

/// C(s) of (10): the servo's response to θ, in volts per radian.
Complex servo(const control::Tuning &tuning, Complex s) {
    const double lambda = tuning.lambda_rad_per_s;
    return tuning.K_P_V_per_rad + tuning.K_D_Vs_per_rad * s * lambda / (s + lambda);
}

TEST(RenderedStiffness, SolvesTheWindingUnderDriftCompensation) {
    std::mt19937 random(1);
    for (int i = 0; i < 200; ++i) {
        const SpringDrive drive = random_drive(random);
        const double k_T = drive.motor.torque_constant_Nm_per_A;
        for (const double omega : {0.1, 10.0, 300.0, 2e3, 1e5}) {
            const Complex s(0.0, omega);
            // (11) with θ = 1: e_W = (Ls + dR) i + k_T s, and e_W = −C from (10).
            const Complex current = (-servo(drive.tuning, s) - k_T * s) /
                                    (drive.motor.inductance_H * s + drive.tuning.dR_Ohm);
            const Complex truth = -k_T * current;
            // Round-off of a dozen operations.
            EXPECT_LT(std::abs(analytic_stiffness(drive, omega) - truth), 1e-13 * std::abs(truth));
        }
    }
}

TEST(RenderedStiffness, ReachesTheLevelsOfThePaper) {
    std::mt19937 random(2);
    for (int i = 0; i < 50; ++i) {
        const SpringDrive drive = random_drive(random);
        const control::Coupling levels =
            control::coupling(drive.motor, drive.tuning, drive.period_s, drive.delay_periods);
        // A thousandth of what the slowest corner, K_P over all that multiplies s, would need.
        const double slow = 1e-3 * drive.tuning.K_P_V_per_rad /
                            (drive.motor.torque_constant_Nm_per_A + drive.tuning.K_D_Vs_per_rad +
                             drive.tuning.K_P_V_per_rad * 0.03);
        // (13) within 0.1 %
        const double K_DC = levels.K_DC_Nm_per_rad;
        EXPECT_NEAR(std::abs(analytic_stiffness(drive, slow)), K_DC, 1e-3 * K_DC);
        EXPECT_NEAR(std::abs(sampled_stiffness(drive, slow)), K_DC, 1e-3 * K_DC);
        EXPECT_NEAR(std::abs(sampled_stiffness(drive, 0.0)), K_DC, 1e-14 * K_DC);
        // (14) within 0.1 %, three decades above the fastest corner of all.
        const double fast = 1e3 * std::max({drive.tuning.dR_Ohm / drive.motor.inductance_H,
                                            drive.tuning.lambda_rad_per_s * 6.0});
        const double K_HF = levels.K_HF_Nm_per_rad;
        EXPECT_NEAR(std::abs(analytic_stiffness(drive, fast)), K_HF, 1e-3 * K_HF);
    }
}

TEST(RenderedStiffness, IsADamperAndASpringInSeriesWithoutTheServo) {
    SpringDrive drive;
    drive.motor = testing::phantom_1_0().motor[0];
    drive.tuning.K_P_V_per_rad = 0.0;
    drive.tuning.K_D_Vs_per_rad = 0.0;
    drive.tuning.dR_Ohm = drive.motor.resistance_Ohm;
    const double K_L = device::inductive_stiffness_Nm_per_rad(drive.motor);
    const double B_R = device::series_damping_Nms_per_rad(drive.motor, drive.motor.resistance_Ohm);
    for (const double omega : {0.1, 10.0, 9160.0, 1e6}) {
        const Complex truth = 1.0 / (1.0 / K_L + 1.0 / Complex(0.0, omega * B_R)); // Fig. 1
        const double round_off = 1e-14 * std::abs(truth);
        EXPECT_LT(std::abs(unmodified_stiffness(drive.motor, omega) - truth), round_off);
        EXPECT_LT(std::abs(analytic_stiffness(drive, omega) - truth), round_off);
        EXPECT_LT(std::abs(sampled_stiffness(drive, omega) - truth), round_off);
    }
}

TEST(RenderedStiffness, SampledFormTendsToTheAnalyticAtFirstOrder) {
    std::mt19937 random(3);
    for (int i = 0; i < 100; ++i) {
        SpringDrive drive = random_drive(random);
        // ω and λ a hundredth of the rate and less: the second order stays below a few per cent.
        const double omega =
            std::exp(std::uniform_real_distribution<double>(std::log(6.0), std::log(2e3))(random));
        drive.period_s = 1e-2 / std::max(omega, drive.tuning.lambda_rad_per_s);
        const Complex truth = analytic_stiffness(drive, omega);
        const Complex error = sampled_stiffness(drive, omega) - truth;
        SpringDrive finer = drive;
        finer.period_s = 0.5 * drive.period_s;
        const Complex finer_error = sampled_stiffness(finer, omega) - truth;
        EXPECT_NEAR(std::log2(std::abs(error) / std::abs(finer_error)), 1.0, 0.1);
        // To first order the filter is exact, and the hold a delay of half a period.
        const Complex s(0.0, omega);
        const Complex predicted = -drive.motor.torque_constant_Nm_per_A /
                                  (drive.motor.inductance_H * s + drive.tuning.dR_Ohm) *
                                  servo(drive.tuning, s) * s * drive.period_s *
                                  (0.5 + drive.delay_periods);
        EXPECT_LT(std::abs(error - predicted), 0.05 * std::abs(predicted));
    }
}

/// The component at ω of e^(jωkT) held from (k + d) T to (k + d + 1) T: its Fourier series over a
/// time of whole periods of both, by the midpoint rule.
Complex held_turn(double delay, int turns, int ticks) {
    constexpr int kPoints = 1000; // in a period; all delays below end at one of them
    const double turn_a_tick = 2.0 * std::numbers::pi * turns / ticks;
    Complex sum = 0.0;
    for (int i = 0; i < ticks * kPoints; ++i) {
        const double time = (i + 0.5) / kPoints;
        const double sampled_at = std::floor(time - delay);
        sum += std::polar(1.0 / (ticks * kPoints), turn_a_tick * (sampled_at - time));
    }
    return sum;
}

TEST(RenderedStiffness, HoldsCommandsLateByAnyFractionOfAPeriod) {
    SpringDrive drive;
    drive.motor = testing::phantom_1_0().motor[0];
    drive.tuning.K_D_Vs_per_rad = 0.0;
    constexpr int kTicks = 40;
    for (const double delay : {0.0, 0.25, 0.5, 0.999, 1.0, 1.3, 2.75, 7.1}) {
        for (const int turns : {1, 7, 19, 33}) {
            drive.delay_periods = delay;
            const double omega = 2.0 * std::numbers::pi * turns / (kTicks * drive.period_s);
            const Complex s(0.0, omega);
            const double k_T = drive.motor.torque_constant_Nm_per_A;
            // C is K_P alone: without winding and back-EMF, K_θ is the response of the hold.
            const Complex volts = sampled_stiffness(drive, omega) *
                                  (drive.motor.inductance_H * s + drive.dR_Ohm()) / k_T;
            const Complex held = (volts - k_T * s) / drive.tuning.K_P_V_per_rad;
            // The midpoint rule: (ωh)²/24 at most, h a thousandth of a period: 1.1e-6.
            EXPECT_LT(std::abs(held - held_turn(delay, turns, kTicks)), 1.2e-6)
                << "d " << delay << ", ωT " << omega * drive.period_s;
        }
    }
}

} // namespace
} // namespace springdrive::loops
