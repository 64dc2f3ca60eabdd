// Covers engine/commissioning/sweep_estimate.cpp: on synthetic measurements
// whose stiffness is known in closed form.
#include "engine/commissioning/sweep.h"

#include "base/degrees.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <tuple>
#include <vector>

namespace springdrive::commissioning {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

TEST(SweepBlock, FindsASineBesideDriftAndDither) {
    const Complex amplitude = std::polar(0.37, 0.9);
    for (const auto &[omega, dither, ticks] :
         {std::tuple(2.0 * pi * 40.0, 2.0 * pi * 6.3, 250), {2.0 * pi * 3.0, 0.0, 333}}) {
        SweepBlock block(omega, dither, 1e-3 * ticks);
        for (int k = 0; k < ticks; ++k) {
            const double t = 1e-3 * k + 2e-5 * (k % 3); // not even evenly
            const double y = (amplitude * std::polar(1.0, omega * t)).real();
            const double slow = dither > 0.0 ? 2.0 * std::cos(dither * t + 0.3) : 0.0;
            block.take({t, y, 5.0 - 3.0 * t + y, y + slow, 7.0});
        }
        const BlockAmplitudes found = block.amplitudes();
        constexpr double kRoundOff = 1e-10;
        EXPECT_NEAR(std::abs(found.excitation_V - amplitude), 0.0, kRoundOff);
        EXPECT_NEAR(std::abs(found.e_W_V - amplitude), 0.0, kRoundOff);
        EXPECT_NEAR(std::abs(found.current_A - amplitude), 0.0, kRoundOff);
        EXPECT_NEAR(std::abs(found.theta_rad), 0.0, kRoundOff);
    }
}

/// One motor whose rotor is an inertia on a spring and a damper, under a sampled and held e_W, in
/// the frequency domain: every component of the held voltage acts on the motor, and all of them
/// meet in the samples.
struct Motor {
    double dR_Ohm = 0.5;
    double inductance_H = 0.238e-3;
    double inertia_kg_m2 = 2e-5;
    double damping_Nms_per_rad = 6.6e-4;
    double stiffness_Nm_per_rad = 0.033;
    double torque_constant_Nm_per_A = 23.4e-3;

    /// Amplitudes at the samples for e_W of 1 V.
    [[nodiscard]] BlockAmplitudes sampled(double frequency_hz, double T, double d) const {
        const double k_T = torque_constant_Nm_per_A;
        constexpr int kComponents = 3000; // the rest is 1e-6
        const double omega = 2.0 * pi * frequency_hz;
        BlockAmplitudes found{1.0, 1.0, 0.0, 0.0};
        for (int m = -kComponents; m <= kComponents; ++m) {
            const Complex s(0.0, omega + 2.0 * pi * m / T);
            const Complex held_V = (1.0 - std::exp(-s * T)) / (s * T) * std::exp(-s * d * T);
            const Complex load_Nms_per_rad =
                inertia_kg_m2 * s + damping_Nms_per_rad + stiffness_Nm_per_rad / s;
            const Complex current_A =
                held_V / (inductance_H * s + dR_Ohm + k_T * k_T / load_Nms_per_rad);
            found.current_A += current_A;
            found.theta_rad += k_T * current_A / load_Nms_per_rad / s;
        }
        return found;
    }

    /// The stiffness that it renders with a drive's law.
    [[nodiscard]] Complex stiffness(loops::SpringDrive drive, double frequency_hz) const {
        drive.tuning.dR_Ohm = dR_Ohm;
        drive.motor.inductance_H = inductance_H;
        drive.motor.torque_constant_Nm_per_A = torque_constant_Nm_per_A;
        return loops::sampled_stiffness(drive, 2.0 * pi * frequency_hz);
    }
};

loops::SpringDrive drive_at(double servo_hz) {
    loops::SpringDrive drive;
    drive.motor = testing::phantom_motor();
    drive.period_s = 1.0 / servo_hz;
    return drive;
}

SweepMeasurement measured(const Motor &motor, double frequency_hz, double servo_hz, double d) {
    SweepMeasurement measurement;
    measurement.frequency_hz = frequency_hz;
    const BlockAmplitudes block = motor.sampled(frequency_hz, 1.0 / servo_hz, d);
    // Blocks begin at any phase.
    for (const double phase : {0.0, 1.0, 2.5}) {
        const Complex turn = std::polar(0.3, phase);
        measurement.blocks.push_back({turn * block.excitation_V, turn * block.e_W_V,
                                      turn * block.current_A, turn * block.theta_rad});
    }
    measurement.delay_periods = d;
    measurement.torque_constant_Nm_per_A = testing::phantom_motor().torque_constant_Nm_per_A;
    return measurement;
}

TEST(SweepEstimate, TakesOutTheAliasesOfWindingAndRotor) {
    for (const double servo_hz : {250.0, 1000.0, 4000.0}) {
        for (const double d : {0.0, 0.3, 1.0, 1.7}) {
            for (const Motor &motor :
                 {Motor{}, Motor{.dR_Ohm = 0.62, .inductance_H = 0.35e-3},
                  Motor{.torque_constant_Nm_per_A = 22.7e-3},
                  Motor{.dR_Ohm = 0.3, .inductance_H = 0.15e-3, .inertia_kg_m2 = 3e-5}}) {
                std::vector<SweepMeasurement> measurements;
                for (const double share : {0.001, 0.004, 0.02, 0.05, 0.1}) {
                    measurements.push_back(measured(motor, share * servo_hz, servo_hz, d));
                }
                const loops::SpringDrive drive = drive_at(servo_hz);
                const MotorSweep sweep = estimate_sweep(drive, measurements);
                for (const SweepPoint &point : sweep.points) {
                    loops::SpringDrive delayed = drive;
                    delayed.delay_periods = d;
                    const Complex error =
                        point.measured_Nm_per_rad / motor.stiffness(delayed, point.frequency_hz) -
                        1.0;
                    // The rotor's aliases neglect damper and spring, which matters most where it
                    // moves far in a period.
                    EXPECT_LT(std::abs(error), servo_hz < 1000.0 ? 5e-3 : 1e-3)
                        << point.frequency_hz << " Hz at " << servo_hz << " Hz, d " << d << ", dR "
                        << motor.dR_Ohm << ", fitted dR " << sweep.winding.dR_Ohm << ", L "
                        << sweep.winding.inductance_H << ", J " << sweep.winding.inertia_kg_m2;
                }
                EXPECT_NEAR(sweep.winding.dR_Ohm, motor.dR_Ohm, 0.005 * motor.dR_Ohm);
                EXPECT_NEAR(sweep.winding.torque_constant_Nm_per_A, motor.torque_constant_Nm_per_A,
                            0.01 * motor.torque_constant_Nm_per_A);
            }
        }
    }
}

TEST(SweepEstimate, AnUndoneAliasWouldShow) {
    // At 250 Hz, without a model of the rotor's aliases, the same comparison fails.
    const Motor motor;
    const loops::SpringDrive drive = drive_at(250.0);
    const std::vector<SweepMeasurement> alone{measured(motor, 25.0, 250.0, 0.3)};
    const std::vector<SweepMeasurement> several{measured(motor, 1.0, 250.0, 0.3),
                                                measured(motor, 5.0, 250.0, 0.3), alone.front()};
    loops::SpringDrive delayed = drive;
    delayed.delay_periods = 0.3;
    const Complex truth = motor.stiffness(delayed, 25.0);
    const auto error = [&](const std::vector<SweepMeasurement> &measurements) {
        return std::abs(
            estimate_sweep(drive, measurements).points.back().measured_Nm_per_rad / truth - 1.0);
    };
    EXPECT_LT(error(several), 2.5e-3);
    EXPECT_GT(error(alone), 4.0 * error(several)); // one point does not tell J from K
}

TEST(SweepEstimate, TheDeviationIsThatOfRepeatedEstimates) {
    std::mt19937_64 random(5);
    std::normal_distribution<double> noise_A(0.0, 0.01);
    const loops::SpringDrive drive = drive_at(1000.0);
    const SweepMeasurement clean = measured(Motor{}, 20.0, 1000.0, 0.3);
    const Complex truth = estimate_sweep(drive, {{clean}}).points.front().measured_Nm_per_rad;
    double scatter = 0.0;
    double stated = 0.0;
    constexpr int kTrials = 400;
    for (int trial = 0; trial < kTrials; ++trial) {
        SweepMeasurement noisy = clean;
        noisy.blocks.assign(8, clean.blocks.front());
        for (BlockAmplitudes &block : noisy.blocks) {
            block.current_A += Complex(noise_A(random), noise_A(random));
        }
        const SweepPoint point = estimate_sweep(drive, {{noisy}}).points.front();
        // One part of the complex error, as a deviation is of magnitude or of phase.
        scatter += 0.5 * std::norm(point.measured_Nm_per_rad / truth - 1.0);
        stated += point.deviation * point.deviation;
    }
    // 400 trials of 8 blocks: 5 %, and a margin.
    EXPECT_NEAR(std::sqrt(stated / kTrials), std::sqrt(scatter / kTrials),
                0.15 * std::sqrt(scatter / kTrials));
    EXPECT_GT(scatter, 0.0);
}

TEST(SweepEstimate, WithoutALoadItSaysThatItDoesNotKnow) {
    // Hardly any torque flows to a free rotor at low frequency.
    std::mt19937_64 random(6);
    std::normal_distribution<double> noise_A(0.0, 2e-4);
    const Motor free{
        .inertia_kg_m2 = 1e-6, .damping_Nms_per_rad = 0.0, .stiffness_Nm_per_rad = 0.0};
    SweepMeasurement measurement = measured(free, 1.0, 1000.0, 0.3);
    measurement.blocks.assign(16, measurement.blocks.front());
    for (BlockAmplitudes &block : measurement.blocks) {
        block.current_A += Complex(noise_A(random), noise_A(random));
    }
    EXPECT_GT(estimate_sweep(drive_at(1000.0), {{measurement}}).points.front().deviation,
              kUncertain);
    // One block alone tells nothing of its deviation.
    measurement.blocks.resize(1);
    EXPECT_GT(estimate_sweep(drive_at(1000.0), {{measurement}}).points.front().deviation, 1e6);
}

TEST(SweepEstimate, ScalesTheLawAsTheServoDoes) {
    // For a motor whose k_T it takes to be smaller, the law makes K_P and K_D larger.
    const Motor motor;
    SweepMeasurement measurement = measured(motor, 1.0, 1000.0, 0.0);
    measurement.torque_constant_Nm_per_A = 0.95 * motor.torque_constant_Nm_per_A;
    const loops::SpringDrive drive = drive_at(1000.0);
    loops::SpringDrive stiffer = drive;
    stiffer.tuning.K_P_V_per_rad /= 0.95;
    stiffer.tuning.K_D_Vs_per_rad /= 0.95;
    const Complex error =
        estimate_sweep(drive, {{measurement}}).points.front().measured_Nm_per_rad /
            motor.stiffness(stiffer, 1.0) -
        1.0;
    EXPECT_LT(std::abs(error), 1e-3);
}

TEST(SweepEstimate, FollowsAnRHatThatChangesMeanwhile) {
    // R̂ was 20 mΩ less at one of the frequencies than at the others, so that dR was 20 mΩ more.
    const loops::SpringDrive drive = drive_at(1000.0);
    std::vector<SweepMeasurement> measurements;
    for (const double frequency_hz : {1.0, 5.0, 30.0, 99.0}) {
        Motor motor;
        motor.dR_Ohm = frequency_hz > 90.0 ? 0.52 : 0.5;
        measurements.push_back(measured(motor, frequency_hz, 1000.0, 0.3));
        measurements.back().cancelled_Ohm = 2.18 - motor.dR_Ohm;
    }
    const MotorSweep sweep = estimate_sweep(drive, measurements);
    EXPECT_NEAR(sweep.winding.dR_Ohm, 0.505, 1e-3);
    EXPECT_NEAR(sweep.winding.inductance_H, 0.238e-3, 2e-6);
    EXPECT_NEAR(sweep.winding.torque_constant_Nm_per_A, 23.4e-3, 5e-5);
    for (SweepMeasurement &measurement : measurements) {
        measurement.cancelled_Ohm = 1.68; // had this not been noted
    }
    EXPECT_GT(
        std::abs(estimate_sweep(drive, measurements).winding.torque_constant_Nm_per_A - 23.4e-3),
        1.5e-4);
}

} // namespace
} // namespace springdrive::commissioning
