// Covers engine/control/motion_control.cpp: the maps, and α over the workspace.
#include "engine/control/motion_control.h"

#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/rendered_force.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace springdrive::control {
namespace {

Configuration at(const device::DeviceDescription &device, const Vector3 &q_rad) {
    Configuration now;
    now.theta_rad = device::motor_from_joint(device.geometry, q_rad);
    now.tip_m = device::tip_position_m(device.geometry, q_rad);
    now.J = device::motor_jacobian(device.geometry, q_rad);
    return now;
}

contact::Contact wall(const Vector3 &x0_m, const Vector3 &normal) {
    contact::Contact contact;
    contact.touching = true;
    contact.x0_m = x0_m;
    contact.normal = normal;
    contact.tangent_projector = Matrix3::Identity() - normal * normal.transpose();
    contact.eta = 0.0;
    contact.active_constraints = 1;
    return contact;
}

/// Links less than 70° from square, and a tip in front of the base axis.
Vector3 random_configuration(std::mt19937_64 &random) {
    std::uniform_real_distribution<double> angle(-1.0, 1.0);
    while (true) {
        const double q2 = 0.6 * angle(random);
        const double q3 = q2 + 1.2 * angle(random);
        if (std::cos(q2) + std::sin(q3) > 0.2) {
            return {angle(random), q2, q3};
        }
    }
}

/// Largest angle between the static force and the surface's normal over all surfaces in the plane
/// of the two joints that remain when the base is locked.
struct PlanarError {
    double inverse_deg = 0.0;
    double transpose_deg = 0.0;
};
PlanarError largest_planar_error(const device::DeviceDescription &device, double q2_deg,
                                 double q3_deg) {
    const Configuration now =
        at(device, Vector3(0.0, q2_deg * kRadiansPerDegree, q3_deg * kRadiansPerDegree));
    const Vector3 weights = relative_stiffness(device);
    // Small enough for J⁻¹ to replace invkin: its curvature bends by less than 1e-4/l = 0.04°.
    constexpr double kPenetration_m = 1e-6;
    PlanarError largest;
    for (int step = 0; step < 3600; ++step) {
        const double angle = 0.1 * step * kRadiansPerDegree;
        const Vector3 normal(0.0, std::sin(angle), std::cos(angle));
        const TipSetPoint target = contact_set_point(
            now.tip_m, Vector3::Zero(), wall(now.tip_m + kPenetration_m * normal, normal), 0.0);
        const MotorSetPoint inverse = inverse_map(device.geometry, now, target).value();
        const MotorSetPoint transpose =
            transpose_map(now, target, alpha_bound(now.J, weights), weights);
        const auto error_deg = [&](const MotorSetPoint &set_point) {
            const Vector3 force =
                static_tip_force(now.J, weights, set_point.theta_Sd_rad - now.theta_rad);
            return direction_error_rad(force, normal) / kRadiansPerDegree;
        };
        largest.inverse_deg = std::max(largest.inverse_deg, error_deg(inverse));
        largest.transpose_deg = std::max(largest.transpose_deg, error_deg(transpose));
    }
    return largest;
}

TEST(MotionControl, LargestErrorOfTheInverseMapIsTheAngleBetweenTheLinks) {
    // docs/design.md, "Linkage and motors": |q₃ − q₂| exactly, where l₁ = l₂ and N₂ = N₃.
    const device::DeviceDescription device = testing::phantom_1_0();
    const PlanarError paper = largest_planar_error(device, 20.0, -15.0);
    EXPECT_NEAR(paper.inverse_deg, 35.0, 0.1);
    EXPECT_LT(paper.transpose_deg, 0.1);
    for (const double elbow_deg : {0.0, 10.0, -25.0, 45.0, -60.0}) {
        const PlanarError error = largest_planar_error(device, -5.0, -5.0 + elbow_deg);
        EXPECT_NEAR(error.inverse_deg, std::abs(elbow_deg), 0.1);
        EXPECT_LT(error.transpose_deg, 1e-6);
    }
}

TEST(MotionControl, AlphaBoundHasItsClosedFormWithTheBaseLocked) {
    // docs/design.md, "Linkage and motors": α = N²/(l²(1 + |sin(q₃ − q₂)|)) for the two joints. The
    // base joint's own eigenvalue is N₁²/r², so the bound for all three is the smaller of the two.
    const device::DeviceDescription device = testing::phantom_1_0();
    const double l = device.geometry.upper_arm_m;
    std::mt19937_64 random(6);
    for (int i = 0; i < 1000; ++i) {
        const Vector3 q = random_configuration(random);
        const double N = device.geometry.transmission_ratio[1];
        const double N1 = device.geometry.transmission_ratio[0];
        const double r = l * (std::cos(q[1]) + std::sin(q[2]));
        const double planar = N * N / (l * l * (1.0 + std::abs(std::sin(q[2] - q[1]))));
        const double expected = std::min(planar, N1 * N1 / (r * r));
        ASSERT_NEAR(alpha_bound(device::motor_jacobian(device.geometry, q), Vector3::Ones()),
                    expected,
                    1e-11 * expected); // round-off of a 3×3 eigenvalue
    }
}

TEST(MotionControl, StiffnessFractionsOfSurfaceAndTuningMultiply) {
    EXPECT_EQ(combined_eta(0.0, 0.0), 0.0);
    EXPECT_EQ(combined_eta(1.0, 0.3), 1.0);
    EXPECT_EQ(combined_eta(0.3, 1.0), 1.0);
    EXPECT_DOUBLE_EQ(combined_eta(0.5, 0.5), 0.75);
}

TEST(MotionControl, TheInverseMapHasNoSolutionWhereTheLinksAlign) {
    const device::DeviceDescription device = testing::phantom_1_0();
    // q₃ − q₂ = −90°: folded onto each other (docs/design.md, "Where methods fail").
    const Configuration now =
        at(device, Vector3(0.0, 70.0 * kRadiansPerDegree, 160.0 * kRadiansPerDegree));
    const Vector3 step_m(0.0, 1e-3, 0.0);
    EXPECT_FALSE(inverse_map(device.geometry, now, {now.tip_m + step_m, Vector3::Ones()}));
    // Out of reach from a good configuration, and within.
    const Configuration good = at(device, Vector3::Zero());
    EXPECT_FALSE(inverse_map(device.geometry, good, {Vector3(1.0, 0.0, 0.0), Vector3::Zero()}));
    EXPECT_TRUE(inverse_map(device.geometry, good, {step_m, Vector3::Zero()}));
    // The replacement gives no more than free space.
    const Vector3 k_T = torque_constants(device);
    Configuration moving = now;
    moving.theta_rate_rad_per_s = Vector3(1.0, -2.0, 3.0);
    EXPECT_EQ(drift_compensation_V(k_T, {}, moving, no_force(moving)),
              k_T.cwiseProduct(moving.theta_rate_rad_per_s));
}

TEST(ForceDirection, IsExactForSmallAnglesAndNaNWithoutForce) {
    const Vector3 normal = Vector3::UnitY();
    EXPECT_DOUBLE_EQ(direction_error_rad(Vector3(3e-9, 3.0, 0.0), normal), 1e-9);
    EXPECT_DOUBLE_EQ(direction_error_rad(Vector3(0.0, -2.0, 0.0), normal), std::numbers::pi);
    EXPECT_TRUE(std::isnan(direction_error_rad(Vector3::Zero(), normal)));
    EXPECT_TRUE(std::isnan(direction_error_rad(normal, Vector3::Zero())));
}

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
    return at(device, testing::random_workspace_angles(device, random));
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
