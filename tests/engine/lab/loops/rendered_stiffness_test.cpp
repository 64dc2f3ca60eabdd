// Covers the stiffness that is rendered at a frequency, of one motor, in the links' plane and at
// the tip:
// engine/lab/loops/{rendered_stiffness,stiffness_sweep,direction_spectrum,tip_stiffness}.cpp.
#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/control/motion_control.h"
#include "engine/control/velocity_filter.h"
#include "engine/lab/limits/stability_simulation.h"
#include "engine/lab/loops/link_plane.h"
#include "engine/lab/loops/rendered_stiffness.h"
#include "tests/support/configurations.h"
#include "tests/support/csv.h"
#include "tests/support/devices.h"
#include "tests/support/sampled_loop.h"
#include "tests/support/stability_cases.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <deque>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

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
    for (const double requested_hz : {1.0, 30.0, 400.0}) {
        const SweepWindow window = sweep_window(requested_hz, drive.period_s);
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
        const double requested_hz = share / period_s;
        const SweepWindow window = sweep_window(requested_hz, period_s);
        EXPECT_GE(window.ticks, 1000);
        EXPECT_GE(window.periods, 1);
        EXPECT_LT(2 * window.periods, window.ticks); // below half the servo rate
        EXPECT_NEAR(window.frequency_hz(period_s), requested_hz, requested_hz / 1999.0);
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

const Vector3 kAngles_rad = kRadiansPerDegree * Vector3(0.0, 20.0, -15.0);

/// The PHANTOM 1.0 with α at its bound, its third motor stronger by `third_k_T`.
PlanarContact contact_with(double third_k_T = 1.0) {
    device::DeviceDescription device = testing::phantom_1_0();
    device.motor[2].torque_constant_Nm_per_A *= third_k_T;
    PlanarContact contact;
    contact.J = planar_jacobian(device.geometry, kAngles_rad);
    contact.alpha_rad2_per_m2 =
        planar_stiffness(device, control::Tuning{}, kAngles_rad).alpha_rad2_per_m2;
    contact.relative_stiffness = control::relative_stiffness(device).tail<2>();
    contact.drive[0].motor = device.motor[1];
    contact.drive[1].motor = device.motor[2];
    return contact;
}

void set_servo(PlanarContact &contact, double lambda_rad_per_s, double period_s, int delay) {
    for (SpringDrive &drive : contact.drive) {
        drive.tuning.lambda_rad_per_s = lambda_rad_per_s;
        drive.period_s = period_s;
        drive.delay_periods = delay;
    }
}

/// docs/design.md, "Contact and maps", with the paper's continuous servo.
Eigen::Matrix2cd continuous_stiffness(const PlanarContact &contact, double omega) {
    const control::Tuning &tuning = contact.drive[0].tuning;
    const device::MotorParameters &motor = contact.drive[0].motor;
    const Complex s(0.0, omega);
    const double k_T = motor.torque_constant_Nm_per_A;
    const Complex F = tuning.lambda_rad_per_s / (s + tuning.lambda_rad_per_s);
    const Eigen::Matrix2cd I = Eigen::Matrix2cd::Identity();
    const Eigen::Matrix2cd A =
        (contact.alpha_rad2_per_m2 * contact.J.transpose() * contact.J).cast<Complex>();
    return k_T / (s * motor.inductance_H + tuning.dR_Ohm) *
           (k_T * s * (I - (I - A) * F) +
            (tuning.K_P_V_per_rad + tuning.K_D_Vs_per_rad * s * F) * A);
}

TEST(DirectionSpectrum, TendsToTheContinuousFormAtFirstOrder) {
    for (const double omega : {10.0, 300.0, 3000.0}) {
        const auto error = [omega](double period_s) {
            PlanarContact contact = contact_with();
            set_servo(contact, 1000.0, period_s, 0);
            const Eigen::Matrix2cd expected = continuous_stiffness(contact, omega);
            return (motor_stiffness(contact, control::MotionMap::transpose, omega) - expected)
                       .norm() /
                   expected.norm();
        };
        EXPECT_LT(error(1e-7), 1e-3) << omega;
        EXPECT_NEAR(std::log2(error(2e-6) / error(1e-6)), 1.0, 0.05) << omega;
    }
}

TEST(DirectionSpectrum, OneMotorAloneIsTheSampledForm) {
    // A = I: no share is free, and (26) is (20).
    PlanarContact contact = contact_with();
    contact.J = 0.012 * Matrix2::Identity();
    contact.alpha_rad2_per_m2 = 1.0 / (0.012 * 0.012);
    set_servo(contact, 700.0, 1e-3, 2);
    for (const double omega : {1.0, 100.0, 2000.0}) {
        const Complex K_theta = sampled_stiffness(contact.drive[0], omega);
        const Eigen::Matrix2cd expected = K_theta * Eigen::Matrix2cd::Identity();
        for (const control::MotionMap map :
             {control::MotionMap::inverse, control::MotionMap::transpose}) {
            EXPECT_LT((motor_stiffness(contact, map, omega) - expected).norm(),
                      1e-12 * std::abs(K_theta));
        }
    }
}

TEST(DirectionSpectrum, SphereAtRestAndEllipsoidFarAboveTheFilter) {
    PlanarContact contact = contact_with();
    set_servo(contact, 1000.0, 1e-9, 0); // as good as continuous
    // ω/λ = 1e-6 reduces the free motors' part to k_T ω/λ · ω/K_P.
    const Eigen::Matrix2cd at_rest = tip_stiffness(contact, control::MotionMap::transpose, 1e-3);
    const double sphere = contact.alpha_rad2_per_m2 *
                          contact.drive[0].motor.torque_constant_Nm_per_A *
                          contact.drive[0].tuning.K_P_V_per_rad / contact.drive[0].tuning.dR_Ohm;
    EXPECT_LT((at_rest - sphere * Eigen::Matrix2cd::Identity()).norm(), 1e-4 * sphere);
    EXPECT_LT(worst_direction_error_rad(at_rest), 1e-6);

    const double far = 1e7; // 1e4 λ; dR/L and K_D λ/k_T are smaller than λ or of its size
    const Matrix2 J_inverse = contact.J.inverse();
    const double K_L = device::inductive_stiffness_Nm_per_rad(contact.drive[0].motor);
    const Matrix2 ellipsoid = K_L * J_inverse.transpose() * J_inverse;
    const Eigen::Matrix2cd fast = tip_stiffness(contact, control::MotionMap::transpose, far);
    EXPECT_LT((fast - ellipsoid.cast<Complex>()).norm(), 1e-3 * ellipsoid.norm());
    EXPECT_NEAR(worst_direction_error_rad(fast) / kRadiansPerDegree, 35.0, 0.1); // |q₃ − q₂|
}

TEST(DirectionSpectrum, InverseMapHasTheSameErrorAtEveryFrequency) {
    const PlanarContact contact = contact_with();
    for (const double omega : {1.0, 50.0, 1000.0, 6000.0}) {
        // A normal within 1/8° of the worst; the error is flat there.
        EXPECT_NEAR(
            worst_direction_error_rad(tip_stiffness(contact, control::MotionMap::inverse, omega)) /
                kRadiansPerDegree,
            35.0, 0.01);
    }
}

TEST(DirectionSpectrum, PhasorErrors) {
    const Vector2 n(1.0, 0.0);
    const auto error_deg = [&n](Complex x, Complex y) {
        return phasor_direction_error_rad({x, y}, n) / kRadiansPerDegree;
    };
    EXPECT_NEAR(error_deg(1.0, 1.0), 45.0, 1e-12);
    EXPECT_NEAR(error_deg(-1.0, 1.0), 45.0, 1e-12);             // a line has no sign
    EXPECT_NEAR(error_deg({0.0, 2.0}, {0.0, 0.0}), 0.0, 1e-12); // nor has a phase a direction
    EXPECT_NEAR(error_deg(1.0, {0.0, 1.0}), 45.0, 1e-12);       // a circle: half lies across
    EXPECT_NEAR(error_deg(1.0, 1e-9), 1e-9 / kRadiansPerDegree, 1e-20); // no digits lost
    EXPECT_NEAR(error_deg(std::sqrt(3.0), 1.0), 30.0, 1e-12);
}

/// The servo's own law on both motors while a vice moves the tip along n: the torques' phasor,
/// per metre, at the frequency `periods`/`ticks` of the servo's.
Eigen::Vector2cd brute_force(const PlanarContact &contact, const Vector2 &n, int periods,
                             int ticks) {
    constexpr int kSubSteps = 40;
    const SpringDrive &drive = contact.drive[0];
    const double T = drive.period_s;
    const double h = T / kSubSteps;
    const double omega = 2.0 * std::numbers::pi * periods / (ticks * T);
    const Vector2 amplitude = contact.J.inverse() * n;
    const auto theta_at = [&](double t) { return Vector2(amplitude * std::cos(omega * t)); };

    control::Configuration now;
    now.J.bottomRightCorner<2, 2>() = contact.J;
    const Vector3 W(1.0, contact.relative_stiffness[0], contact.relative_stiffness[1]);
    const Vector3 k_T(1.0, contact.drive[0].motor.torque_constant_Nm_per_A,
                      contact.drive[1].motor.torque_constant_Nm_per_A);
    const double pole = control::velocity_filter_pole(drive.tuning.lambda_rad_per_s, T);
    control::VelocityFilter filter;
    std::deque<Vector3> held(static_cast<std::size_t>(drive.delay_periods) + 1, Vector3::Zero());
    Vector2 current_A = Vector2::Zero();
    Eigen::Vector2cd sum = Eigen::Vector2cd::Zero();
    for (int k = -ticks; k < ticks; ++k) { // the first window lets the transient decay
        const double t = k * T;
        now.theta_rad << 0.0, theta_at(t);
        now.theta_rate_rad_per_s = filter.update(now.theta_rad, pole, T);
        now.tip_m = now.J * now.theta_rad;
        const control::MotorSetPoint set_point =
            control::transpose_map(now, {}, contact.alpha_rad2_per_m2, W);
        held.push_front(control::drift_compensation_V(k_T, drive.tuning, now, set_point));
        held.pop_back();
        for (int i = 0; i < kSubSteps; ++i) {
            const double from = t + i * h;
            const Vector2 rate = (theta_at(from + h) - theta_at(from)) / h;
            const Complex turn = std::polar(1.0, -omega * (from + 0.5 * h));
            for (Eigen::Index j = 0; j < 2; ++j) {
                const device::MotorParameters &motor =
                    contact.drive[static_cast<std::size_t>(j)].motor;
                const device::WindingStep step = device::winding_step(motor, drive.dR_Ohm(), h);
                const double u_V = held.back()[j + 1] - k_T[j + 1] * rate[j];
                const double mean_A = step.mean_decay * current_A[j] + step.mean_gain_A_per_V * u_V;
                current_A[j] = step.decay * current_A[j] + step.gain_A_per_V * u_V;
                sum[j] -= k >= 0 ? k_T[j + 1] * mean_A * turn : Complex(0.0);
            }
        }
    }
    return 2.0 * sum / (kSubSteps * ticks); // cos ωt has half its amplitude at +ω
}

TEST(DirectionSpectrum, AgreesWithTheServosLaw) {
    // Compared with the servo's own functions on exactly integrated windings, with equal and
    // unequal motors. A sub-step takes (ωh)²/8 from a sine, at 200 Hz 1.2e-4.
    for (const double third_k_T : {1.0, 1.2}) {
        PlanarContact contact = contact_with(third_k_T);
        set_servo(contact, 800.0, 1e-3, 1);
        for (const int periods : {10, 50, 200}) {
            const double omega = 2.0 * std::numbers::pi * periods;
            const Vector2 n = direction_at(0.7);
            const Eigen::Vector2cd measured = brute_force(contact, n, periods, 1000);
            const Eigen::Vector2cd predicted =
                motor_stiffness(contact, control::MotionMap::transpose, omega) *
                (contact.J.inverse() * n).cast<Complex>();
            EXPECT_LT((measured - predicted).norm(), 5e-4 * predicted.norm())
                << periods << " Hz, " << third_k_T;
        }
    }
}

StabilityCase wall() {
    StabilityCase which = testing::firm();
    which.drive = device::AmplifierKind::current_drive;
    which.wall = {800.0, 5.0};
    return which;
}

const Vector3 kSlanted = Vector3(0.3, 0.8, -0.5).normalized();

/// With equal motors and the inverse map, the tip has K_θ through J⁻¹: (21).
TEST(TipStiffness, IsTheSampledCouplingThroughTheInverseMap) {
    StabilityCase which = testing::firm();
    which.tuning.map = control::MotionMap::inverse;
    const Matrix3 J = device::motor_jacobian(which.device.geometry, which.q_rad);
    const double share = (J.inverse() * kSlanted).squaredNorm();
    for (const double delay : {1.0, 0.4, 2.75}) {
        which.delay_periods = delay;
        const SpringDrive drive{which.device.motor[0], which.tuning, which.period_s, delay};
        for (const double hz : {1.0, 30.0, 300.0, 450.0}) {
            const double omega = 2.0 * std::numbers::pi * hz;
            const std::complex<double> truth = share * sampled_stiffness(drive, omega);
            EXPECT_LT(std::abs(tip_stiffness(which, kSlanted, omega) - truth),
                      1e-9 * std::abs(truth))
                << hz << " Hz, d " << delay;
        }
    }
}

/// (27) and (13): α k_T K_P/dR, whatever the direction.
TEST(TipStiffness, IsASphereAtRestUnderTheTransposeMap) {
    const StabilityCase which = testing::firm();
    const control::Coupling c =
        control::coupling(which.device.motor[0], which.tuning, which.period_s, 0);
    const double alpha =
        control::alpha_bound(device::motor_jacobian(which.device.geometry, which.q_rad),
                             control::relative_stiffness(which.device));
    for (const Vector3 &n : {Vector3(Vector3::UnitX()), Vector3(Vector3::UnitY()), kSlanted}) {
        const std::complex<double> found = tip_stiffness(which, n, 0.0);
        EXPECT_NEAR(found.real(), alpha * c.K_DC_Nm_per_rad, 1e-9 * found.real());
        EXPECT_NEAR(found.imag(), 0.0, 1e-9 * found.real());
    }
}

TEST(TipStiffness, IsFeltAsRenderedOnRigidLinksAndInSeriesBehindATip) {
    std::mt19937_64 random(5);
    for (int i = 0; i < 20; ++i) {
        StabilityCase which = testing::firm();
        which.q_rad = testing::random_workspace_angles(which.device, random);
        const Matrix3 rendered = felt_at_rest_N_per_m(which, {});
        for (const Vector3 &n : {Vector3(Vector3::UnitY()), kSlanted}) {
            const double along = n.normalized().dot(rendered * n.normalized());
            EXPECT_NEAR(along, tip_stiffness(which, n, 0.0).real(), 1e-9 * along) << i;
        }
        // The transpose map's sphere K behind the sphere 1/K_s.
        const double K = rendered(0, 0);
        const double K_s = which.device.structure.stiffness_N_per_m;
        EXPECT_LT(
            (felt_at_rest_N_per_m(which, {0.0}) - K * K_s / (K + K_s) * Matrix3::Identity()).norm(),
            1e-6 * K) // of J's differences
            << i;
    }
}

TEST(TipStiffness, TendsToTheInductanceAlone) {
    const StabilityCase which = testing::firm();
    const double limit = inductive_tip_stiffness(which, kSlanted);
    const auto off = [&](double omega) {
        return std::abs(std::abs(tip_stiffness(which, kSlanted, omega)) / limit - 1.0);
    };
    // The remainder is of order dR/(ωL), in quadrature, and of the hold's 1/(ωT).
    EXPECT_LT(off(1e6), 1e-2);
    EXPECT_LT(off(1e8), 1e-4);
}

TEST(TipStiffness, OfACurrentDriveIsItsWallAtRestAndZeroAtHighFrequency) {
    const StabilityCase which = wall();
    EXPECT_NEAR(tip_stiffness(which, kSlanted, 0.0).real(), 800.0, 1e-6);
    EXPECT_LT(std::abs(tip_stiffness(which, kSlanted, 1e8)), 1e-2);
    EXPECT_EQ(inductive_tip_stiffness(which, kSlanted), 0.0);
    // Far below λ and the servo, K + jωB.
    const double omega = 2.0 * std::numbers::pi;
    EXPECT_NEAR(tip_stiffness(which, kSlanted, omega).imag(), 5.0 * omega, 0.2 * 5.0 * omega);
}

/// The force of a count with a wall: K and the filtered rate's B, by the lever of the worst motor,
/// reduced by the amplifier's bandwidth of 2 kHz within a millisecond.
TEST(ForceOfACount, IsTheWallsForceOverTheTipsMotionOfACount) {
    const StabilityCase which = wall();
    const double count_rad = 2.0 * std::numbers::pi / which.device.encoder_counts_per_turn;
    const Matrix3 J = device::motor_jacobian(which.device.geometry, which.q_rad);
    const double a = std::exp(-which.tuning.lambda_rad_per_s * which.period_s);
    const double per_metre = 800.0 + 5.0 * (1.0 - a) / which.period_s;
    const double reached =
        1.0 - std::exp(-2.0 * std::numbers::pi * 2000.0 * which.period_s); // 1 − 3.5e-6
    const double truth = per_metre * count_rad * J.colwise().norm().maxCoeff() * reached;
    EXPECT_NEAR(force_of_a_count_N(which), truth, 1e-9 * truth);
}

/// With the inverse map the motors are independent: the voltage through dR and L for a period, (11)
/// with a rotor that hardly moves in that time.
TEST(ForceOfACount, IsTheGainsThroughTheWinding) {
    StabilityCase which = testing::firm();
    which.tuning.map = control::MotionMap::inverse;
    const device::MotorParameters &motor = which.device.motor[0];
    const control::Tuning &tuning = which.tuning;
    const double count_rad = 2.0 * std::numbers::pi / which.device.encoder_counts_per_turn;
    const double a = std::exp(-tuning.lambda_rad_per_s * which.period_s);
    const double e_W_V =
        count_rad * (tuning.K_P_V_per_rad + tuning.K_D_Vs_per_rad * (1.0 - a) / which.period_s);
    const double current_A = e_W_V / tuning.dR_Ohm *
                             (1.0 - std::exp(-tuning.dR_Ohm * which.period_s / motor.inductance_H));
    const Matrix3 J = device::motor_jacobian(which.device.geometry, which.q_rad);
    const double truth = motor.torque_constant_Nm_per_A * current_A *
                         Matrix3(J.transpose().inverse()).colwise().norm().maxCoeff();
    // In a millisecond a rotor does move: its back-EMF reduces the current by K_L T²/J at most.
    EXPECT_LT(force_of_a_count_N(which), truth);
    EXPECT_GT(force_of_a_count_N(which), 0.8 * truth);
}

} // namespace
} // namespace springdrive::loops
