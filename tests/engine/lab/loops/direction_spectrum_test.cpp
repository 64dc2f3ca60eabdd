// Covers engine/lab/loops/direction_spectrum.cpp.
#include "engine/lab/loops/direction_spectrum.h"

#include "base/degrees.h"
#include "engine/control/motion_control.h"
#include "engine/control/velocity_filter.h"
#include "engine/lab/loops/stiffness_ellipse.h"
#include "tests/support/devices.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <deque>
#include <numbers>

namespace springdrive::loops {
namespace {

using Complex = std::complex<double>;

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

} // namespace
} // namespace springdrive::loops
