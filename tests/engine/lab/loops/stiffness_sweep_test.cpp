// Covers engine/lab/loops/stiffness_sweep.cpp.
#include "engine/lab/loops/stiffness_sweep.h"

#include "tests/support/csv.h"
#include "tests/support/devices.h"
#include "tests/support/sampled_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::loops {
namespace {

using std::numbers::pi;

SpringDrive random_drive(std::mt19937 &random, const device::MotorParameters &motor) {
    const auto between = [&random](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    const auto spread = [&between](double low, double high) {
        return std::exp(between(std::log(low), std::log(high)));
    };
    SpringDrive drive;
    drive.motor = motor;
    drive.tuning.dR_Ohm = spread(0.02, 2.0);
    drive.tuning.K_P_V_per_rad = between(0.0, 20.0);
    drive.tuning.K_D_Vs_per_rad = between(0.0, 0.1);
    drive.tuning.lambda_rad_per_s = spread(100.0, 5000.0);
    drive.period_s = 1.0 / spread(500.0, 10000.0);
    drive.delay_periods = std::uniform_int_distribution<int>(0, 2)(random);
    return drive;
}

/// Tunings under which the motor with its load comes to rest by itself.
std::vector<SpringDrive> stable_drives(std::size_t count) {
    std::mt19937 random(5);
    const device::DeviceDescription device = testing::phantom_1_0();
    const device::RotorLoad load = device_load(device, 1);
    std::vector<SpringDrive> drives;
    while (drives.size() < count) {
        const SpringDrive drive = random_drive(random, device.motor[1]);
        if (is_stable({drive, load, {}})) {
            drives.push_back(drive);
        }
    }
    return drives;
}

TEST(SimulatedSweep, MeasuredAgreesWithSampledForRandomStableTuningsAndDelays) {
    std::mt19937 random(7);
    double largest_difference = 0.0;
    for (SpringDrive drive : stable_drives(50)) {
        for (const bool whole : {true, false}) {
            drive.delay_periods = whole ? drive.delay_periods
                                        : std::uniform_real_distribution<double>(0.0, 3.0)(random);
            const SweepRange range{1.0, 0.25 / drive.period_s, whole ? 8 : 5};
            for (const StiffnessPoint &point : stiffness_sweep(drive, range)) {
                const std::complex<double> ratio =
                    point.measured_Nm_per_rad / point.sampled_Nm_per_rad;
                largest_difference = std::max(largest_difference, std::abs(ratio - 1.0));
            }
        }
    }
    // 5e-5 is the bound of the header; the rest is for tunings whose parts nearly cancel.
    EXPECT_LT(largest_difference, 2e-4);
    RecordProperty("largest_difference", std::to_string(largest_difference));
}

TEST(SimulatedSweep, DetectsADelayThatTheSampledFormLacks) {
    for (SpringDrive drive : stable_drives(5)) {
        const SweepWindow window = sweep_window(0.1 / drive.period_s, drive.period_s);
        const double omega = 2.0 * pi * window.frequency_hz(drive.period_s);
        const std::complex<double> truth = sampled_stiffness(drive, omega);
        drive.delay_periods += 0.1;
        // Five times the effect of the sub-steps.
        EXPECT_GT(std::abs(measured_stiffness(drive, window) / truth - 1.0), 1e-3);
        drive.delay_periods += 0.9;
        EXPECT_GT(std::abs(measured_stiffness(drive, window) / truth - 1.0), 0.01);
    }
}

TEST(SimulatedSweep, MeetsWholeDelaysFromBothSides) {
    for (SpringDrive drive : stable_drives(5)) {
        const SweepWindow window = sweep_window(0.1 / drive.period_s, drive.period_s);
        drive.delay_periods = 1.0;
        const std::complex<double> at_one = measured_stiffness(drive, window);
        for (const double aside : {-1e-9, 1e-9}) {
            drive.delay_periods = 1.0 + aside;
            // A part of a period with its own step does not change the sub-steps; the delay does,
            // by 1e-9 of 0.6 rad. Times the possible cancellation of parts.
            EXPECT_LT(std::abs(measured_stiffness(drive, window) - at_one),
                      1e-7 * std::abs(at_one));
        }
    }
}

TEST(SimulatedSweep, MeasuresTheShortedWindingWithoutAServo) {
    SpringDrive drive;
    drive.motor = testing::phantom_1_0().motor[0];
    drive.tuning.K_P_V_per_rad = 0.0;
    drive.tuning.K_D_Vs_per_rad = 0.0;
    drive.tuning.dR_Ohm = drive.motor.resistance_Ohm;
    for (const double asked_hz : {1.0, 30.0, 400.0}) {
        const SweepWindow window = sweep_window(asked_hz, drive.period_s);
        const double omega = 2.0 * pi * window.frequency_hz(drive.period_s);
        const std::complex<double> truth = unmodified_stiffness(drive.motor, omega);
        EXPECT_LT(std::abs(measured_stiffness(drive, window) - truth), 5e-5 * std::abs(truth));
    }
}

TEST(SimulatedSweep, AnEncoderBlursByNoMoreThanItsQuantum) {
    SpringDrive drive;
    drive.motor = testing::phantom_1_0().motor[0];
    drive.tuning.K_D_Vs_per_rad = 0.0;
    const SweepWindow window = sweep_window(20.0, drive.period_s);
    const double quantum = 2.0 * pi / 4096.0;
    for (const double amplitude : {0.01, 0.1, 1.0}) {
        const double difference = std::abs(measured_stiffness(drive, window, {amplitude, quantum}) -
                                           measured_stiffness(drive, window));
        // |error of θ| <= quantum/2, whose first harmonic is at most 4/π times that, through K_DC.
        const double K_DC =
            drive.motor.torque_constant_Nm_per_A * drive.tuning.K_P_V_per_rad / drive.tuning.dR_Ohm;
        EXPECT_LT(difference, K_DC * 4.0 / pi * 0.5 * quantum / amplitude);
        EXPECT_GT(difference, 0.0);
    }
}

TEST(SweepWindow, HoldsWholePeriodsAndTicksNearTheRequestedFrequency) {
    std::mt19937 random(6);
    for (int i = 0; i < 2000; ++i) {
        const double period_s = 1.0 / std::uniform_real_distribution<double>(250.0, 1e4)(random);
        const double share = std::exp(std::uniform_real_distribution<double>(-10.0, -0.7)(random));
        const double asked_hz = share / period_s;
        const SweepWindow window = sweep_window(asked_hz, period_s);
        EXPECT_GE(window.ticks, 1000);
        EXPECT_GE(window.periods, 1);
        EXPECT_LT(2 * window.periods, window.ticks); // below half the servo rate
        EXPECT_NEAR(window.frequency_hz(period_s), asked_hz, asked_hz / 1999.0);
    }
    // Half the servo rate itself is where sine and alias meet: just below it.
    const SweepWindow half = sweep_window(500.0, 1e-3);
    EXPECT_LT(half.frequency_hz(1e-3), 500.0);
    EXPECT_GT(half.frequency_hz(1e-3), 499.0);
}

TEST(StiffnessCsv, HasTheDocumentedColumns) {
    SpringDrive drive;
    drive.motor = testing::phantom_1_0().motor[0];
    std::ostringstream text;
    write_csv(text, stiffness_table(stiffness_sweep(drive, {1.0, 250.0, 3})));
    const auto lines = testing::parsed_csv(text.str());
    ASSERT_EQ(lines.size(), 4U);
    EXPECT_EQ(lines[0], (std::vector<std::string>{"freq_hz", "analytic_mag", "analytic_phase_deg",
                                                  "sampled_mag", "sampled_phase_deg",
                                                  "measured_mag", "measured_phase_deg"}));
    for (const auto &line : lines) {
        EXPECT_EQ(line.size(), lines[0].size());
    }
}

} // namespace
} // namespace springdrive::loops
