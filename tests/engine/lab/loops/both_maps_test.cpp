// Covers engine/lab/loops/both_maps.cpp.
#include "engine/lab/loops/both_maps.h"

#include "base/degrees.h"
#include "device/core/motor/motor.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/force_direction.h"
#include "engine/control/haptic_law.h"
#include "tests/support/devices.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace springdrive::loops {
namespace {

constexpr double kRoundOffOfMaps = 1e-9; // inverse kinematics and a 3×3 inverse

/// Configurations well within the range of the links, and off the base's axis, where J is singular.
class ManyPoses {
public:
    Vector3 next_rad() {
        Vector3 q_rad = Vector3::Zero();
        double share = 0.0; // of the links' length, from the axis
        while (share < 0.5) {
            const double q2 = uniform_(generator_) * 40.0;
            q_rad = kRadiansPerDegree *
                    Vector3(uniform_(generator_) * 60.0, q2, q2 + uniform_(generator_) * 60.0);
            share = std::cos(q_rad[1]) + std::sin(q_rad[2]);
        }
        return q_rad;
    }
    Vector3 direction() {
        return Vector3(uniform_(generator_), uniform_(generator_), uniform_(generator_))
            .normalized();
    }

private:
    std::mt19937 generator_{11};
    std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

/// At rest, pressed by `depth_m` into a rigid surface.
struct Pressed {
    control::Configuration now;
    contact::Contact contact;
};

Pressed pressed(const device::DeviceDescription &device, const Vector3 &q_rad,
                const Vector3 &normal, double depth_m) {
    const Vector3 theta_rad = device::motor_from_joint(device.geometry, q_rad);
    Pressed made{control::HapticLaw(device).configuration(theta_rad, Vector3::Zero()), {}};
    made.contact.touching = true;
    made.contact.normal = normal;
    made.contact.x0_m = made.now.tip_m + depth_m * normal;
    made.contact.eta = 0.0;
    return made;
}

TEST(BothMaps, TransposeForceIsAlongTheNormalAsStiffAsTheClosedForm) {
    // (27) with (29) for equal links: α = min(N²/(l² (1 + |sin(q₃ − q₂)|)), N₁²/r²), where r is the
    // tip's distance from the base's axis, as the base's column of J is square to the others.
    const device::DeviceDescription device = testing::phantom_1_0();
    const device::PhantomGeometry &g = device.geometry;
    ASSERT_EQ(g.upper_arm_m, g.forearm_m);
    ASSERT_EQ(g.transmission_ratio[1], g.transmission_ratio[2]);
    control::Tuning tuning;
    tuning.eta = 0.25;
    const double K_DC = device.motor[0].torque_constant_Nm_per_A * tuning.K_P_V_per_rad /
                        tuning.dR_Ohm; // (13); its motors are alike
    ManyPoses poses;
    for (int i = 0; i < 100; ++i) {
        const Vector3 q_rad = poses.next_rad();
        const Vector3 normal = poses.direction();
        const double r_m = g.upper_arm_m * std::cos(q_rad[1]) + g.forearm_m * std::sin(q_rad[2]);
        const double in_plane = std::pow(g.transmission_ratio[1] / g.upper_arm_m, 2.0) /
                                (1.0 + std::abs(std::sin(q_rad[2] - q_rad[1])));
        const double alpha = std::min(in_plane, std::pow(g.transmission_ratio[0] / r_m, 2.0));
        constexpr double kDepth_m = 0.004;
        const Pressed press = pressed(device, q_rad, normal, kDepth_m);
        const MapForces forces = map_forces(device, press.now, press.contact, tuning, 0.0);
        const Vector3 expected_N = 0.75 * alpha * K_DC * kDepth_m * normal;
        EXPECT_LT((forces.transpose_N - expected_N).norm(), kRoundOffOfMaps * expected_N.norm());
        const auto stiffness = map_stiffness(device, tuning, q_rad, alpha);
        ASSERT_TRUE(stiffness);
        EXPECT_NEAR(stiffness->transpose_N_per_m * kDepth_m, expected_N.norm(),
                    kRoundOffOfMaps * expected_N.norm());
    }
}

TEST(BothMaps, InverseForceDoesTheWorkOfTheMotorsTorques) {
    // Virtual work: F · ∂x/∂θ_j = K_q (θ_Sd − θ)_j, with ∂x/∂θ by differences of the kinematics.
    const device::DeviceDescription device = testing::phantom_premium_1_5();
    const control::Tuning tuning;
    ManyPoses poses;
    for (int i = 0; i < 50; ++i) {
        const Vector3 q_rad = poses.next_rad();
        const Pressed press = pressed(device, q_rad, poses.direction(), 0.003);
        const MapForces forces = map_forces(device, press.now, press.contact, tuning, 0.0);
        ASSERT_TRUE(forces.inverse_N);
        const Vector3 q_Sd_rad =
            device::joint_angles_rad(device.geometry, press.contact.x0_m).value();
        for (Eigen::Index j = 0; j < 3; ++j) {
            const auto motor = static_cast<std::size_t>(j);
            const double K_q =
                device.motor[motor].torque_constant_Nm_per_A * tuning.K_P_V_per_rad / tuning.dR_Ohm;
            const double ratio = device.geometry.transmission_ratio[j];
            const double torque_Nm = K_q * ratio * (q_Sd_rad[j] - q_rad[j]);
            constexpr double kStep_rad = 1e-5; // central: error of the order of its square
            const Vector3 turn = kStep_rad * Vector3::Unit(j);
            const Vector3 way_m = (device::tip_position_m(device.geometry, q_rad + turn) -
                                   device::tip_position_m(device.geometry, q_rad - turn)) /
                                  (2.0 * kStep_rad * ratio);
            EXPECT_NEAR(forces.inverse_N->dot(way_m), torque_Nm, 1e-7) << i << ' ' << j;
        }
    }
}

TEST(BothMaps, StiffnessOfTheInverseMapIsTheSlopeOfItsForce) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const control::Tuning tuning;
    ManyPoses poses;
    for (int i = 0; i < 50; ++i) {
        const Vector3 q_rad = poses.next_rad();
        const auto stiffness = map_stiffness(device, tuning, q_rad, 1.0);
        ASSERT_TRUE(stiffness);
        for (int axis = 0; axis < 3; ++axis) {
            constexpr double kStep_m = 1e-5;
            const auto force_N = [&](double depth_m) {
                const Pressed press = pressed(device, q_rad, Vector3::Unit(axis), depth_m);
                return map_forces(device, press.now, press.contact, tuning, 0.0).inverse_N.value();
            };
            const Vector3 slope = (force_N(kStep_m) - force_N(-kStep_m)) / (2.0 * kStep_m);
            const Vector3 column = stiffness->inverse_N_per_m.col(axis);
            // Curved kinematics: of the order of (step/link)².
            EXPECT_LT((slope - column).norm(), 1e-5 * stiffness->inverse_N_per_m.norm());
        }
    }
}

TEST(BothMaps, LargestErrorIsThatOfTheWorstNormal) {
    const device::DeviceDescription device = testing::phantom_1_0();
    ManyPoses poses;
    for (int i = 0; i < 10; ++i) {
        const Matrix3 K = map_stiffness(device, {}, poses.next_rad(), 1.0).value().inverse_N_per_m;
        double worst_rad = 0.0;
        constexpr int kAround = 600;
        for (int row = 0; row <= kAround; ++row) {
            for (int column = 0; column < kAround; ++column) {
                const double latitude = std::numbers::pi * row / kAround;
                const double longitude = std::numbers::pi * column / kAround; // n and −n are alike
                const Vector3 n(std::sin(latitude) * std::cos(longitude),
                                std::sin(latitude) * std::sin(longitude), std::cos(latitude));
                worst_rad = std::max(worst_rad, control::direction_error_rad(K * n, n));
            }
        }
        const double found_rad = largest_error_rad(K);
        EXPECT_LE(worst_rad, found_rad + 1e-12);
        EXPECT_GT(worst_rad, found_rad - 1e-3); // between neighbours of the grid
    }
    EXPECT_NEAR(largest_error_rad(3.0 * Matrix3::Identity()), 0.0, 1e-7);
    EXPECT_TRUE(std::isnan(largest_error_rad(Matrix3::Zero())));
}

TEST(BothMaps, WorkspaceHoldsPlacesThatTheTipCanReachAndTheirValues) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const control::Tuning tuning;
    constexpr double kSpacing_m = 0.03;
    const auto errors = errors_in_workspace_rad(device, tuning, kSpacing_m);
    const auto stiffnesses = stiffnesses_in_workspace_N_per_m(device, tuning, kSpacing_m);
    ASSERT_GT(errors.size(), 50U);
    ASSERT_EQ(errors.size(), stiffnesses.size());
    for (std::size_t i = 0; i < errors.size(); ++i) {
        EXPECT_TRUE(device::can_reach(device, errors[i].tip_m));
        const Vector3 beside_m = errors[i].tip_m - device.workspace.centre_m;
        EXPECT_TRUE(
            (beside_m.array().abs() <= 0.5 * device.workspace.size_m.array() + 1e-12).all());
        const Vector3 q_rad = device::joint_angles_rad(device.geometry, errors[i].tip_m).value();
        // In the plane of the links alone it is |q₃ − q₂|: other normals may only add to it.
        EXPECT_GE(errors[i].value, std::abs(q_rad[2] - q_rad[1]) - 1e-9);
        EXPECT_LT(errors[i].value, 0.5 * std::numbers::pi);
        // (28): no direction of the inverse map is softer than the transpose map's sphere.
        const Matrix3 K = map_stiffness(device, tuning, q_rad, 1.0).value().inverse_N_per_m;
        const Vector3 n = Vector3(0.2, 0.5, -0.8).normalized();
        EXPECT_GE((K * n).norm(), stiffnesses[i].value * (1.0 - 1e-9));
    }
}

} // namespace
} // namespace springdrive::loops
