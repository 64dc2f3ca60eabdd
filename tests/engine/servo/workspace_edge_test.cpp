// Covers engine/servo/workspace_edge.cpp.
#include "engine/servo/workspace_edge.h"

#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace springdrive::servo {
namespace {

/// How far `value` is outside [lowest, highest], without a sign.
double outside(double value, double minimum, double maximum) {
    return std::max({0.0, minimum - value, value - maximum});
}

/// ½ K for each of the three joints and the fold, squared.
double potential_J(const device::DeviceDescription &device, const Vector3 &q_rad) {
    const device::JointLimits &limits = device.joint_limits;
    const double margin_rad = device.edge.margin_rad;
    double sum = 0.0;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const double over_rad =
            outside(q_rad[j], limits.min_rad[j] + margin_rad, limits.max_rad[j] - margin_rad);
        sum += over_rad * over_rad;
    }
    const double over_rad = outside(q_rad[2] - q_rad[1], limits.min_q3_minus_q2_rad + margin_rad,
                                    limits.max_q3_minus_q2_rad - margin_rad);
    return 0.5 * device.edge.stiffness_Nm_per_rad * (sum + over_rad * over_rad);
}

/// Over all angles and beyond, the stops among them.
Vector3 any_angles(std::mt19937_64 &random) {
    return Vector3(0.0, 0.0, 1.6) + testing::random_vector(random, 2.4);
}

class WorkspaceEdgeTest : public ::testing::Test {
protected:
    [[nodiscard]] Vector3 torque_Nm(const Vector3 &q_rad,
                                    const Vector3 &rate_rad_per_s = Vector3::Zero()) const {
        return edge_torque_Nm(device, q_rad, rate_rad_per_s);
    }

    device::DeviceDescription device = testing::phantom_1_0();
    std::mt19937_64 random{2};
};

TEST_F(WorkspaceEdgeTest, AtRestItIsTheGradientOfAPotential) {
    constexpr double kStep_rad = 1e-6;
    int at_edge = 0;
    for (int run = 0; run < 5000; ++run) {
        const Vector3 q_rad = any_angles(random);
        Vector3 gradient_Nm;
        for (Eigen::Index j = 0; j < 3; ++j) {
            const Vector3 step_rad = kStep_rad * Vector3::Unit(j);
            gradient_Nm[j] =
                (potential_J(device, q_rad + step_rad) - potential_J(device, q_rad - step_rad)) /
                (2.0 * kStep_rad);
        }
        const Vector3 found_Nm = torque_Nm(q_rad);
        ASSERT_LT((found_Nm + gradient_Nm).norm(), 1e-5) << q_rad.transpose();
        at_edge += found_Nm.isZero(0.0) ? 0 : 1;
    }
    EXPECT_GT(at_edge, 500);
    EXPECT_LT(at_edge, 4900);
}

TEST_F(WorkspaceEdgeTest, IsZeroWithinAtAnySpeed) {
    device::JointLimits within = device.joint_limits;
    const double margin_rad = device.edge.margin_rad;
    within.min_rad.array() += margin_rad;
    within.max_rad.array() -= margin_rad;
    within.min_q3_minus_q2_rad += margin_rad;
    within.max_q3_minus_q2_rad -= margin_rad;
    int tried = 0;
    for (int run = 0; run < 20'000; ++run) {
        const Vector3 q_rad = any_angles(random);
        if (within.allow(q_rad)) {
            ++tried;
            ASSERT_TRUE(torque_Nm(q_rad, testing::random_vector(random, 50.0)).isZero(0.0));
            ASSERT_EQ(beyond_limits(device.joint_limits, q_rad, margin_rad).max_excess_rad(), 0.0);
        }
    }
    EXPECT_GT(tried, 500);
}

TEST_F(WorkspaceEdgeTest, IsContinuousAtRest) {
    // Along straight lines through all angles no step is larger than that of the springs: one at
    // the joint and two, each by both angles, at the fold.
    for (int run = 0; run < 50; ++run) {
        const Vector3 from_rad = any_angles(random);
        const Vector3 to_rad = any_angles(random);
        constexpr int kSteps = 1000;
        const double step_rad = (to_rad - from_rad).norm() / kSteps;
        Vector3 before_Nm = torque_Nm(from_rad);
        for (int i = 1; i <= kSteps; ++i) {
            const Vector3 now_Nm = torque_Nm(from_rad + (to_rad - from_rad) * i / kSteps);
            ASSERT_LE((now_Nm - before_Nm).norm(),
                      3.0 * device.edge.stiffness_Nm_per_rad * step_rad * (1 + 1e-9));
            before_Nm = now_Nm;
        }
    }
}

TEST_F(WorkspaceEdgeTest, OnlyPushesBack) {
    // Each joint alone, at any speed: its torque points inwards or is zero; when moving outwards it
    // is larger than at rest, when moving back smaller.
    const Vector3 middle_rad(0.0, 0.3, 0.3);
    for (const Eigen::Index j : {0, 1, 2}) {
        for (const double sign : {-1.0, 1.0}) {
            Vector3 q_rad = middle_rad;
            const double margin_rad = device.edge.margin_rad;
            const double edge_rad = sign > 0.0 ? device.joint_limits.max_rad[j] - margin_rad
                                               : device.joint_limits.min_rad[j] + margin_rad;
            q_rad[j] = edge_rad + sign * 0.02;
            if (j == 1) {
                q_rad[2] = q_rad[1]; // not folded
            } else if (j == 2) {
                q_rad[1] = q_rad[2];
            }
            const double rest_Nm = torque_Nm(q_rad)[j];
            EXPECT_NEAR(rest_Nm, -sign * 0.02 * device.edge.stiffness_Nm_per_rad, 1e-12);
            for (int run = 0; run < 100; ++run) {
                const Vector3 rate = testing::random_vector(random, 10.0);
                Vector3 alone = Vector3::Zero();
                alone[j] = rate[j];
                const double found_Nm = torque_Nm(q_rad, alone)[j];
                ASSERT_LE(sign * found_Nm, 0.0);
                ASSERT_NEAR(found_Nm,
                            sign * std::min(0.0, sign * (rest_Nm - device.edge.damping_Nms_per_rad *
                                                                       rate[j])),
                            1e-12);
            }
        }
    }
}

TEST_F(WorkspaceEdgeTest, TheFoldPushesBothLinksEqually) {
    for (const double sign : {-1.0, 1.0}) {
        const double edge_rad =
            sign > 0.0 ? device.joint_limits.max_q3_minus_q2_rad - device.edge.margin_rad
                       : device.joint_limits.min_q3_minus_q2_rad + device.edge.margin_rad;
        const Vector3 q_rad(0.0, 1.0, 1.0 + edge_rad + sign * 0.01);
        const Vector3 found_Nm = torque_Nm(q_rad);
        EXPECT_EQ(found_Nm[0], 0.0);
        EXPECT_NEAR(found_Nm[2], -sign * 0.01 * device.edge.stiffness_Nm_per_rad, 1e-12);
        EXPECT_EQ(found_Nm[1], -found_Nm[2]);
        // Turning both links together is not folding; further folding is opposed.
        EXPECT_EQ(torque_Nm(q_rad, Vector3(0.0, 3.0, 3.0)), found_Nm);
        EXPECT_LT(sign * torque_Nm(q_rad, Vector3(0.0, 0.0, sign))[2], sign * found_Nm[2]);
    }
}

TEST_F(WorkspaceEdgeTest, IsPassive) {
    // On a closed path through the wall at any speed the wall absorbs energy: −∮ τ·dq ≥ 0.
    for (int run = 0; run < 50; ++run) {
        const Vector3 centre_rad = any_angles(random);
        const Vector3 a_rad = testing::random_vector(random, 0.5);
        const Vector3 b_rad = testing::random_vector(random, 0.5);
        const double speed_rad_per_s = 6.0;
        constexpr int kSteps = 20'000;
        const double step = 2.0 * 3.141592653589793 / kSteps;
        double taken_J = 0.0;
        for (int i = 0; i < kSteps; ++i) {
            const double phase = (i + 0.5) * step;
            const Vector3 q_rad = centre_rad + std::cos(phase) * a_rad + std::sin(phase) * b_rad;
            const Vector3 slope = -std::sin(phase) * a_rad + std::cos(phase) * b_rad;
            taken_J -= torque_Nm(q_rad, speed_rad_per_s * slope).dot(slope) * step;
        }
        ASSERT_GT(taken_J, -1e-6) << run;
    }
}

TEST_F(WorkspaceEdgeTest, BeyondLimitsHasTheSignOfTheSide) {
    const device::JointLimits &limits = device.joint_limits;
    const BeyondLimits low = beyond_limits(limits, limits.min_rad - Vector3(0.1, 0.2, 0.3), 0.0);
    EXPECT_LT((low.joint_rad + Vector3(0.1, 0.2, 0.3)).norm(), 1e-12);
    const BeyondLimits high = beyond_limits(limits, limits.max_rad + Vector3(0.1, 0.2, 0.3), 0.0);
    EXPECT_LT((high.joint_rad - Vector3(0.1, 0.2, 0.3)).norm(), 1e-12);
    const Vector3 folded(0.0, 0.8, 0.8 + limits.min_q3_minus_q2_rad - 0.05);
    EXPECT_NEAR(beyond_limits(limits, folded, 0.0).fold_rad, -0.05, 1e-12);
    EXPECT_NEAR(beyond_limits(limits, folded, 0.0).max_excess_rad(), 0.05, 1e-12);
}

} // namespace
} // namespace springdrive::servo
