// Covers engine/control/motion_control.cpp: α over the workspace.
#include "device/core/phantom/kinematics.h"
#include "engine/control/force_direction.h"
#include "engine/control/motion_control.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace springdrive::control {
namespace {

/// Both devices, with the motors of their data sheets and with unequal motors.
std::vector<device::DeviceDescription> devices_and_unequal_ones() {
    std::vector<device::DeviceDescription> devices{testing::phantom_1_0(),
                                                   testing::phantom_premium_1_5()};
    for (device::DeviceDescription device : {devices[0], devices[1]}) {
        device.motor[1].torque_constant_Nm_per_A *= 1.2;
        device.motor[2].torque_constant_Nm_per_A *= 0.8;
        devices.push_back(device);
    }
    return devices;
}

Configuration random_place(const device::DeviceDescription &device, std::mt19937_64 &random) {
    const Vector3 q_rad = testing::random_workspace_angles(device, random);
    Configuration now;
    now.theta_rad = device::motor_from_joint(device.geometry, q_rad);
    now.tip_m = device::tip_position_m(device.geometry, q_rad);
    now.J = device::motor_jacobian(device.geometry, q_rad);
    return now;
}

/// K_trans (27) over k̄, column by column: the static force (22) for a gap along each axis.
Matrix3 transpose_stiffness(const Configuration &now, double alpha, const Vector3 &weights) {
    Matrix3 stiffness;
    for (int axis = 0; axis < 3; ++axis) {
        const Vector3 gap = Vector3::Unit(axis);
        const MotorSetPoint set_point =
            transpose_map(now, {now.tip_m + gap, Vector3::Zero()}, alpha, weights);
        stiffness.col(axis) =
            static_tip_force(now.J, weights, set_point.theta_Sd_rad - now.theta_rad);
    }
    return stiffness;
}

TEST(Alpha, AtItsBoundRendersASphereThatTouchesTheEllipsoidFromWithin) {
    // (25)–(28): K_trans = α k̄ I, whose λ_max is at most λ_min(K_inv), the two equal at the bound.
    // A part in a million above, the sphere is outside.
    std::mt19937_64 random(7);
    for (const device::DeviceDescription &device : devices_and_unequal_ones()) {
        const Vector3 weights = relative_stiffness(device);
        ASSERT_NEAR(weights.mean(), 1.0, 1e-15);
        for (int i = 0; i < 1000; ++i) {
            const Configuration now = random_place(device, random);
            const double alpha = alpha_bound(now.J, weights);
            // Round-off of J⁻ᵀ W (α W⁻¹ Jᵀ), grown by the condition of J.
            const Matrix3 K_trans = transpose_stiffness(now, alpha, weights);
            const double condition = now.J.norm() * now.J.inverse().norm();
            const double round_off = 1e-15 * condition;
            ASSERT_LT((K_trans / alpha - Matrix3::Identity()).norm(), 10.0 * round_off);

            const Matrix3 K_inv =
                now.J.transpose().inverse() * weights.asDiagonal() * now.J.inverse();
            const double minimum =
                Eigen::SelfAdjointEigenSolver<Matrix3>(K_inv).eigenvalues().minCoeff();
            // An eigenvalue is found to ε of the largest of its matrix, the square of J's
            // condition.
            const double touching = 1e-15 * condition * condition;
            ASSERT_LT(touching, 1e-7);
            ASSERT_NEAR(alpha / minimum, 1.0, touching);
            const double above = transpose_stiffness(now, (1.0 + 1e-6) * alpha, weights)(0, 0);
            ASSERT_GT(above, minimum);
        }
    }
}

/// Tip per turn of the motors by differences of the forward kinematics, motors weighed as in (29).
double largest_stretch(const device::DeviceDescription &device, const Vector3 &q_rad,
                       const Vector3 &weights) {
    constexpr double kTurn_rad = 1e-5;
    const Vector3 theta_rad = device::motor_from_joint(device.geometry, q_rad);
    Matrix3 stretch;
    for (int motor = 0; motor < 3; ++motor) {
        const Vector3 turn = kTurn_rad * Vector3::Unit(motor);
        const auto tip = [&](const Vector3 &at) {
            return device::tip_position_m(device.geometry,
                                          device::joint_from_motor(device.geometry, at));
        };
        stretch.col(motor) = (tip(theta_rad + turn) - tip(theta_rad - turn)) / (2.0 * kTurn_rad) /
                             std::sqrt(weights[motor]);
    }
    return Eigen::JacobiSVD<Matrix3>(stretch).singularValues()[0];
}

TEST(Alpha, GlobalIsTheMinimumOverTheWorkspaceGrid) {
    constexpr int kPoints = 7;
    for (const device::DeviceDescription &device : devices_and_unequal_ones()) {
        const Vector3 weights = relative_stiffness(device);
        double maximum = 0.0;
        for (int i = 0; i < kPoints * kPoints * kPoints; ++i) {
            const Eigen::Vector3i index(i % kPoints, i / kPoints % kPoints,
                                        i / (kPoints * kPoints));
            const Vector3 share = index.cast<double>() / (kPoints - 1) - Vector3::Constant(0.5);
            const auto q_rad = device::joint_angles_rad(
                device.geometry,
                device.workspace.centre_m + share.cwiseProduct(device.workspace.size_m));
            maximum = q_rad ? std::max(maximum, largest_stretch(device, *q_rad, weights)) : maximum;
        }
        // Central differences: 1e-10 of truncation, 1e-11 of round-off over 1e-5 rad.
        EXPECT_NEAR(global_alpha_bound(device, kPoints) * maximum * maximum, 1.0, 1e-8);
    }
}

TEST(Alpha, GlobalIsWithinTheBoundBetweenTheGridPointsToo) {
    std::mt19937_64 random(9);
    for (const device::DeviceDescription &device : devices_and_unequal_ones()) {
        const double global = global_alpha_bound(device);
        double minimum = INFINITY;
        for (int i = 0; i < 5000; ++i) {
            const Vector3 q = testing::random_workspace_angles(device, random);
            minimum = std::min(minimum, alpha_bound(device::motor_jacobian(device.geometry, q),
                                                    relative_stiffness(device)));
        }
        // The grid may miss the true minimum by the change of α over half its pitch.
        EXPECT_LT(global, 1.02 * minimum);
        EXPECT_GT(global, 0.8 * minimum);
    }
}

} // namespace
} // namespace springdrive::control
