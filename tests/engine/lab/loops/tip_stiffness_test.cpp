// Covers engine/lab/loops/tip_stiffness.cpp.
#include "engine/lab/loops/tip_stiffness.h"

#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/control/motion_control.h"
#include "tests/support/devices.h"
#include "tests/support/stability_cases.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace springdrive::loops {
namespace {

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
