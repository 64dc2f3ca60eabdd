// Covers engine/lab/charts/servo_rate_chart.cpp.
#include "engine/lab/charts/servo_rate_chart.h"

#include "base/input_error.h"
#include "device/core/phantom/kinematics.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

namespace springdrive::charts {
namespace {

loops::SpringDrive drive_at(double rate_Hz, double delay) {
    return {testing::phantom_1_0().motor[1], control::Tuning{}, 1.0 / rate_Hz, delay};
}

// The band that the header states.
constexpr double kMinJudged_Hz = 2.0;
constexpr double kMaxJudged_Hz = 100.0;

/// The same error from the sampled closed form, instead of the simulated motor.
double predicted_error(const loops::SpringDrive &drive, int points) {
    double sum = 0.0;
    for (int i = 0; i < points; ++i) {
        const double omega = 2.0 * std::numbers::pi * kMinJudged_Hz *
                             std::pow(kMaxJudged_Hz / kMinJudged_Hz, i / (points - 1.0));
        const std::complex<double> truth = loops::analytic_stiffness(drive, omega);
        sum += std::norm((loops::sampled_stiffness(drive, omega) - truth) / truth);
    }
    return std::sqrt(sum / points);
}

TEST(ServoRateTrial, MeasuredErrorIsThatOfTheSampledForm) {
    for (const int delay : {0, 2}) {
        for (const double rate_Hz : {500.0, 4000.0}) {
            const loops::SpringDrive drive = drive_at(rate_Hz, delay);
            // The sweep's own error is 5e-5 of each part; its frequencies move by 1/2000.
            EXPECT_NEAR(stiffness_error(drive, 8), predicted_error(drive, 8), 1e-3);
        }
    }
}

TEST(ServoRateTrial, ErrorGoesToZeroAtFirstOrder) {
    for (const int delay : {0, 1}) {
        const double coarse = stiffness_error(drive_at(5000.0, delay), 6);
        const double fine = stiffness_error(drive_at(20'000.0, delay), 6);
        EXPECT_NEAR(std::log2(coarse / fine) / 2.0, 1.0, 0.05) << delay;
        EXPECT_LT(fine, 0.02);
    }
}

TEST(ServoRateTrial, DirectionTendsToThatOfTheContinuousServo) {
    // The limit is the error due to λ; convergence is of first order in T.
    const device::DeviceDescription device = testing::phantom_1_0();
    const auto error = [&](double rate_Hz) {
        return perceived_direction_error_rad(device, control::Tuning{}, 1.0 / rate_Hz);
    };
    const double limit = error(1e7);
    EXPECT_NEAR(std::log2((error(8000.0) - limit) / (error(16'000.0) - limit)), 1.0, 0.05);
    control::Tuning quick;
    quick.lambda_rad_per_s = 1e5;
    EXPECT_LT(perceived_direction_error_rad(device, quick, 1e-7), 0.03 * limit);
}

TEST(ServoRateTrial, LateAndSlowServosAreUnstable) {
    const device::DeviceDescription device = testing::phantom_1_0();
    EXPECT_TRUE(is_stable_on_all_motors(device, control::Tuning{}, 1e-3, 0));
    EXPECT_TRUE(is_stable_on_all_motors(device, control::Tuning{}, 1e-3, 1));
    EXPECT_FALSE(is_stable_on_all_motors(device, control::Tuning{}, 4e-3, 2));
    EXPECT_FALSE(is_stable_on_all_motors(device, control::Tuning{}, 2e-2, 0));
}

TEST(ServoRateTrial, TimesAServoThatRuns) {
    ChartSetting setting;
    setting.device = testing::phantom_1_0();
    setting.repeats = 1;
    EXPECT_GT(cost_of_servo_tick(setting).min_ns, 0.0);
    setting.device.limits.tip_speed_m_per_s = 1e-4; // the hand is faster
    EXPECT_THROW(static_cast<void>(cost_of_servo_tick(setting)), InputError);
}

} // namespace
} // namespace springdrive::charts
