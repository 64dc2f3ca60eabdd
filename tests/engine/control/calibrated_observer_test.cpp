// Covers what engine/control/winding_observer.cpp makes of a device's calibration.
#include "engine/control/winding_observer.h"
#include "engine/servo/winding_observers.h"

#include "device/core/calibration_file.h"
#include "device/simulated/calibration_tour.h"
#include "device/simulated/sampled_device.h"
#include "engine/lab/rig/servo_rig.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace springdrive::control {
namespace {

constexpr double kPeriod_s = 1e-3;

device::DeviceDescription calibrated(const std::string &kind, double transmission_ratio = 0.0) {
    device::DeviceDescription device = testing::phantom_1_0();
    if (transmission_ratio > 0.0) {
        device.geometry.transmission_ratio.setConstant(transmission_ratio);
    }
    device::Calibration calibration;
    calibration.serial = "7";
    calibration.kind = kind;
    calibration.air_error_K = 2.0;
    calibration.motor.fill(
        {2.1, 1e-3, 0.03, -0.02, 5e-4, 0.004, 0.007, 4e-4, 23.1e-3, 1e-5, 0.012, 2e-5});
    device.calibration = calibration;
    return device;
}

TEST(CalibratedObserver, StartsFromTheCalibration) {
    const device::DeviceDescription device = calibrated("simulated");
    const device::MotorCalibration &known = device.calibration->motor[1];
    const WindingObserver observer(device, 1, kPeriod_s);
    EXPECT_EQ(observer.unheated().resistance_Ohm, known.resistance_Ohm);
    // Air then within 2 K, and now within 10 K of 25 °C, both uniform.
    const double air_Ohm = 2.1 * 0.0039 * std::sqrt((2.0 * 2.0 + 10.0 * 10.0) / 3.0);
    EXPECT_NEAR(observer.unheated().deviation_Ohm, std::hypot(air_Ohm, 1e-3), 1e-9);
    EXPECT_EQ(observer.motor(0.0).torque_constant_Nm_per_A, known.torque_constant_Nm_per_A);
    EXPECT_EQ(observer.motor(0.0).offset_A, known.offset_A);
    for (const double theta_rad : {0.0, 0.1, 2.0, -5.0}) {
        const double phase_rad = 11.0 * theta_rad;
        EXPECT_NEAR(observer.expected_Ohm(theta_rad),
                    2.1 + 0.03 * std::cos(phase_rad) - 0.02 * std::sin(phase_rad) +
                        0.004 * std::cos(2.0 * phase_rad) + 0.007 * std::sin(2.0 * phase_rad),
                    1e-12);
    }
    const device::MotorCalibration learned = observer.learned();
    EXPECT_NEAR(learned.ripple_deviation_Ohm, known.ripple_deviation_Ohm, 1e-12);
    EXPECT_NEAR(learned.offset_deviation_A, known.offset_deviation_A, 1e-12);
}

// A board measures its sensors' offsets whenever it powers up.
TEST(CalibratedObserver, TakesNoOffsetFromABoard) {
    const device::DeviceDescription device = calibrated("USB");
    const device::MotorCalibration learned = WindingObserver(device, 0, kPeriod_s).learned();
    EXPECT_EQ(learned.offset_A, 0.0);
    EXPECT_NEAR(learned.offset_deviation_A, 0.02 / std::sqrt(3.0), 1e-12);
}

/// Mean and standard deviation of R at an angle if the zero is off by δ, normal with `sigma_rad` at
/// the rotor: by numerical integration.
ResistanceEstimate integrated(const device::MotorCalibration &known, double theta_rad,
                              double sigma_rad) {
    double weight = 0.0;
    double sum = 0.0;
    double squares = 0.0;
    constexpr int kSteps = 4000;
    for (int i = -kSteps; i <= kSteps; ++i) {
        const double deviations = 6.0 * i / kSteps;
        const double phase_rad = 11.0 * (theta_rad - deviations * sigma_rad);
        const double R_Ohm = known.ripple_cos_Ohm * std::cos(phase_rad) +
                             known.ripple_sin_Ohm * std::sin(phase_rad) +
                             known.ripple_cos_2_Ohm * std::cos(2.0 * phase_rad) +
                             known.ripple_sin_2_Ohm * std::sin(2.0 * phase_rad);
        const double density = std::exp(-0.5 * deviations * deviations);
        weight += density;
        sum += density * R_Ohm;
        squares += density * R_Ohm * R_Ohm;
    }
    const double mean_Ohm = sum / weight;
    return {known.resistance_Ohm + mean_Ohm, std::sqrt(squares / weight - mean_Ohm * mean_Ohm)};
}

// The covariance leaves out how the two harmonics go together, so that their variances are compared
// with one of them only.
TEST(CalibratedObserver, ItsRippleFadesWithAZeroFoundByEye) {
    for (const double ratio : {0.3, 1.0, 2.0, 11.2}) {
        for (const bool has_second : {false, true}) {
            device::DeviceDescription device = calibrated("USB", ratio);
            device::MotorCalibration &known = device.calibration->motor[0];
            if (has_second) {
                known.ripple_cos_Ohm = known.ripple_sin_Ohm = 0.0;
            } else {
                known.ripple_cos_2_Ohm = known.ripple_sin_2_Ohm = 0.0;
            }
            const double sigma_rad = ratio * device::kZeroByEye_rad / std::sqrt(3.0);
            const WindingObserver observer(device, 0, kPeriod_s);
            for (const double theta_rad : {0.0, 0.05, 0.11, 0.3}) {
                const ResistanceEstimate R = observer.at(theta_rad);
                const ResistanceEstimate expected = integrated(known, theta_rad, sigma_rad);
                EXPECT_NEAR(R.resistance_Ohm, expected.resistance_Ohm, 1e-6) << ratio;
                // cos² + sin² of each harmonic's own deviation
                const double measured_Ohm2 = 5e-4 * 5e-4 + 4e-4 * 4e-4;
                const double mean_Ohm2 = std::pow(observer.unheated().deviation_Ohm, 2);
                EXPECT_NEAR(std::pow(R.deviation_Ohm, 2) - mean_Ohm2 - measured_Ohm2,
                            std::pow(expected.deviation_Ohm, 2), 1e-9)
                    << ratio << ", " << theta_rad;
            }
        }
    }
}

TEST(CalibratedObserver, AnotherZeroIsTakenToBeFoundByEye) {
    const device::DeviceDescription device = calibrated("simulated");
    WindingObserver observer(device, 0, kPeriod_s);
    const double before_Ohm = observer.expected_Ohm(0.0);
    observer.forget_zero();
    observer.restart();
    EXPECT_NEAR(before_Ohm, 2.134, 1e-12);
    EXPECT_NEAR(observer.expected_Ohm(0.0), 2.1, 1e-3);
    EXPECT_EQ(observer.motor(0.0).offset_A, 0.0);
}

TEST(CalibratedObserver, WhatContradictsItselfIsTheFilesMotorAgain) {
    const device::DeviceDescription device = calibrated("simulated");
    WindingObserver observer(device, 0, kPeriod_s);
    observer.distrust();
    EXPECT_EQ(observer.mean().resistance_Ohm, 2.18);
    const double kind_Ohm =
        WindingObserver(testing::phantom_1_0(), 0, kPeriod_s).mean().deviation_Ohm;
    EXPECT_EQ(observer.mean().deviation_Ohm, kind_Ohm);
    EXPECT_FALSE(observer.is_trusted());
    observer.restart();
    EXPECT_EQ(observer.mean().resistance_Ohm, 2.1);
}

// Until observations have agreed for a while, a sensor that fails would not be noticed: 5 % of R.
TEST(CalibratedObserver, ItsDeviationIsNotBelieved) {
    device::DeviceDescription device = calibrated("simulated");
    EXPECT_GT(held_up_dR_Ohm(servo::used_at_start(testing::phantom_1_0(), 0)), 0.75);
    EXPECT_NEAR(held_up_dR_Ohm(servo::used_at_start(device, 0)), 3.0 * 0.05 * 2.1, 1e-12);
}

/// The least net resistance of a drawn device that is moved with a drag, with this calibration.
double min_dR_Ohm(const device::DeviceDescription &device, std::uint64_t seed) {
    simulated::SimulationOptions options;
    options.device_seed = seed;
    options.ambient_C = 15.0; // R is lowest
    const Vector3 start_m = device.workspace.centre_m;
    rig::ServoRig rig(device, options, start_m);
    rig.inputs.tuning.dR_Ohm = 0.02; // R̂ as large as anyone permits
    rig.inputs.observes_resistance = true;
    const simulated::SampledDevice drawn = simulated::sampled_device(device, seed);
    double least_Ohm = std::numeric_limits<double>::infinity();
    for (int tick = 0; tick < 6000; ++tick) {
        if (tick == 1500) {
            rig.phantom().follow(simulated::calibration_tour(device, start_m, 10.0));
        }
        const double swing = std::sin(2e-3 * std::numbers::pi * tick);
        rig.inputs.excitation_V = Vector3::Constant(0.05 * swing);
        rig.tick();
        for (std::size_t j = 0; j < 3; ++j) {
            const auto i = static_cast<Eigen::Index>(j);
            least_Ohm = std::min(least_Ohm, rig.truth().resistance_Ohm[i] -
                                                drawn.motor[j].sensing.amplifier.gain *
                                                    rig.last.command.cancelled_resistance_Ohm[i]);
        }
    }
    return least_Ohm;
}

// Numbers typed by hand that are just possible: R too high by as much as the ranges allow, exact.
TEST(CalibratedObserver, AWrongOneNeverCancelsMoreThanThereIs) {
    for (const std::uint64_t seed : {1U, 5U, 9U}) {
        device::DeviceDescription device = testing::phantom_1_0();
        device::Calibration wrong;
        wrong.serial = "any";
        wrong.kind = "simulated";
        for (std::size_t j = 0; j < 3; ++j) {
            for (const device::CalibrationField &field :
                 device::calibration_fields(device, j, wrong.air_error_K)) {
                const bool is_deviation = field.key.find("deviation") != std::string_view::npos;
                wrong.motor[j].*field.value =
                    is_deviation ? field.range.minimum : 0.999 * field.range.maximum;
            }
        }
        ASSERT_EQ(device::validate(wrong, device), "");
        device.calibration = wrong;
        EXPECT_GT(min_dR_Ohm(device, seed), 0.005 * 2.18) << seed;
    }
}

} // namespace
} // namespace springdrive::control
