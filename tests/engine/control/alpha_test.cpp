// Covers engine/control/motion_control.cpp: α over the workspace.
#include "device/core/phantom/kinematics.h"
#include "engine/control/force_direction.h"
#include "engine/control/motion_control.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace springdrive::control {
namespace {

/// Both devices, with the motors of their data sheet and with motors that are not alike.
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
            const double least =
                Eigen::SelfAdjointEigenSolver<Matrix3>(K_inv).eigenvalues().minCoeff();
            // An eigenvalue is found to ε of the largest of its matrix, the square of J's
            // condition.
            const double touching = 1e-15 * condition * condition;
            ASSERT_LT(touching, 1e-7);
            ASSERT_NEAR(alpha / least, 1.0, touching);
            const double above = transpose_stiffness(now, (1.0 + 1e-6) * alpha, weights)(0, 0);
            ASSERT_GT(above, least);
        }
    }
}

TEST(Alpha, GlobalIsTheLeastOverTheWorkspaceGrid) {
    constexpr int kPoints = 15;
    for (const device::DeviceDescription &device : devices_and_unequal_ones()) {
        const double global = global_alpha_bound(device, kPoints);
        double least = INFINITY;
        for (int i = 0; i < kPoints * kPoints * kPoints; ++i) {
            const Eigen::Vector3i index(i % kPoints, i / kPoints % kPoints,
                                        i / (kPoints * kPoints));
            const Vector3 share = index.cast<double>() / (kPoints - 1) - Vector3::Constant(0.5);
            const auto q = device::joint_angles_rad(
                device.geometry,
                device.workspace.centre_m + share.cwiseProduct(device.workspace.size_m));
            if (q) {
                const double here = alpha_bound(device::motor_jacobian(device.geometry, *q),
                                                relative_stiffness(device));
                // Round-off of where the grid's points are.
                ASSERT_LE(global, here * (1.0 + 1e-12));
                least = std::min(least, here);
            }
        }
        EXPECT_NEAR(global / least, 1.0, 1e-12);
    }
}

TEST(Alpha, GlobalIsWithinTheBoundBetweenTheGridPointsToo) {
    std::mt19937_64 random(9);
    for (const device::DeviceDescription &device : devices_and_unequal_ones()) {
        const double global = global_alpha_bound(device);
        double least = INFINITY;
        for (int i = 0; i < 5000; ++i) {
            const Vector3 q = testing::random_workspace_angles(device, random);
            least = std::min(least, alpha_bound(device::motor_jacobian(device.geometry, q),
                                                relative_stiffness(device)));
        }
        // The grid may miss the true least by what α changes over half its pitch.
        EXPECT_LT(global, 1.02 * least);
        EXPECT_GT(global, 0.8 * least);
    }
}

} // namespace
} // namespace springdrive::control
