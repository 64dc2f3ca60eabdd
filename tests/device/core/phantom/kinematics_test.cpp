// Covers device/core/phantom/kinematics.cpp.
#include "device/core/phantom/kinematics.h"

#include "base/degrees.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <random>

namespace springdrive::device {
namespace {

/// Joint angles well inside the branch of `joint_angles_rad`.
Vector3 random_configuration(std::mt19937_64 &random) {
    std::uniform_real_distribution<double> angle(-1.0, 1.0);
    const double q2 = 0.9 * angle(random);
    return {1.2 * angle(random), q2, q2 + 80.0 * kRadiansPerDegree * angle(random)};
}

bool is_on_the_branch(const PhantomGeometry &g, const Vector3 &q) {
    return g.upper_arm_m * std::cos(q[1]) + g.forearm_m * std::sin(q[2]) > 0.01;
}

class Kinematics : public ::testing::TestWithParam<DeviceDescription> {
protected:
    [[nodiscard]] const PhantomGeometry &geometry() const { return GetParam().geometry; }
};

TEST_P(Kinematics, ZeroPoseHasItsTipAtTheOrigin) {
    EXPECT_EQ(tip_position_m(geometry(), Vector3::Zero()), Vector3::Zero());
}

TEST_P(Kinematics, JacobiansAgreeWithFiniteDifferencesOverTheWorkspace) {
    std::mt19937_64 random(1);
    // Central differences of positions of about l: the sum of round-off ε l/h and truncation h² l/6
    // is smallest at h = (3ε)^(1/3) = 7e-6, about 2e-11 l each.
    constexpr double kStep = 7e-6;
    constexpr double kRelative = 1e-9;
    for (int i = 0; i < 1000; ++i) {
        const Vector3 q = testing::random_workspace_angles(GetParam(), random);
        const Matrix3 jacobian = joint_jacobian(geometry(), q);
        const Matrix3 motor = motor_jacobian(geometry(), q);
        for (int joint = 0; joint < 3; ++joint) {
            const Vector3 step = kStep * Vector3::Unit(joint);
            const Vector3 difference =
                (tip_position_m(geometry(), q + step) - tip_position_m(geometry(), q - step)) /
                (2.0 * kStep);
            const double tolerance = kRelative * difference.norm();
            ASSERT_LT((jacobian.col(joint) - difference).norm(), tolerance);
            ASSERT_LT((motor.col(joint) * geometry().transmission_ratio[joint] - difference).norm(),
                      tolerance);
        }
    }
}

TEST_P(Kinematics, JacobianRateAgreesWithFiniteDifferencesOverTheWorkspace) {
    std::mt19937_64 random(2);
    constexpr double kFastest_rad_per_s = 3.0;
    // As above, for a motion whose fastest term turns at up to 3·3 rad/s.
    constexpr double kDifference_s = 1e-6;
    for (int i = 0; i < 1000; ++i) {
        const Vector3 q = testing::random_workspace_angles(GetParam(), random);
        const Vector3 w = testing::random_vector(random, kFastest_rad_per_s);
        const Matrix3 difference = (joint_jacobian(geometry(), q + kDifference_s * w) -
                                    joint_jacobian(geometry(), q - kDifference_s * w)) /
                                   (2.0 * kDifference_s);
        ASSERT_LT((joint_jacobian_rate(geometry(), q, w) - difference).norm(),
                  1e-9 * joint_jacobian(geometry(), q).norm() * kFastest_rad_per_s);
    }
}

TEST_P(Kinematics, JacobiansHoldOutsideTheWorkspaceToo) {
    // Near the ends of the branch, links up to 80° from perpendicular, and behind the base axis.
    std::mt19937_64 random(5);
    constexpr double kStep = 7e-6;
    for (int i = 0; i < 1000; ++i) {
        const Vector3 q = random_configuration(random);
        const Vector3 w = testing::random_vector(random, 1.0);
        const Vector3 difference = (tip_position_m(geometry(), q + kStep * w) -
                                    tip_position_m(geometry(), q - kStep * w)) /
                                   (2.0 * kStep);
        ASSERT_LT((joint_jacobian(geometry(), q) * w - difference).norm(), 1e-9);
    }
}

TEST_P(Kinematics, InverseUndoesForward) {
    std::mt19937_64 random(3);
    int tried = 0;
    for (int i = 0; i < 1000; ++i) {
        const Vector3 q = random_configuration(random);
        if (!is_on_the_branch(geometry(), q)) {
            continue;
        }
        ++tried;
        const std::optional<Vector3> back =
            joint_angles_rad(geometry(), tip_position_m(geometry(), q));
        ASSERT_TRUE(back.has_value());
        // The arc sine at 80° of elbow loses a factor 1/cos 80° ≈ 6 of the round-off.
        ASSERT_LT((*back - q).norm(), 1e-12);
    }
    EXPECT_GT(tried, 500);
}

TEST_P(Kinematics, PointsOutOfReachHaveNoAngles) {
    const double reach = geometry().upper_arm_m + geometry().forearm_m;
    const Vector3 shoulder(0.0, geometry().forearm_m, -geometry().upper_arm_m);
    const Vector3 forward = Vector3::UnitZ();
    EXPECT_TRUE(joint_angles_rad(geometry(), shoulder + 0.999 * reach * forward).has_value());
    EXPECT_FALSE(joint_angles_rad(geometry(), shoulder + 1.001 * reach * forward).has_value());
    EXPECT_FALSE(joint_angles_rad(geometry(), Vector3(NAN, 0.0, 0.0)).has_value());
    EXPECT_FALSE(joint_angles_rad(geometry(), Vector3(INFINITY, 0.0, 0.0)).has_value());
}

TEST_P(Kinematics, TheDrawnLinkageIsRigidAndEndsAtTheTip) {
    std::mt19937_64 random(4);
    for (int i = 0; i < 200; ++i) {
        const Vector3 q = random_configuration(random);
        const LinkagePose pose = linkage_pose(geometry(), q);
        ASSERT_LT((pose.tip_m - tip_position_m(geometry(), q)).norm(), 1e-15);
        ASSERT_NEAR((pose.elbow_m - pose.base_m).norm(), geometry().upper_arm_m, 1e-15);
        ASSERT_NEAR((pose.tip_m - pose.elbow_m).norm(), geometry().forearm_m, 1e-15);
        // A parallelogram: the rod is as long as the upper arm and parallel to it.
        ASSERT_LT(((pose.coupling_m - pose.crank_m) - (pose.elbow_m - pose.base_m)).norm(), 1e-15);
        ASSERT_NEAR((pose.crank_m - pose.base_m).norm(), geometry().crank_m, 1e-15);
    }
}

INSTANTIATE_TEST_SUITE_P(Devices, Kinematics,
                         ::testing::Values(testing::phantom_1_0(), testing::phantom_premium_1_5()),
                         [](const auto &instance) {
                             return instance.param.geometry.upper_arm_m < 0.2 ? "Phantom10"
                                                                              : "Premium15";
                         });

TEST(TipPlace, IsPositionAndJacobianInOne) {
    const PhantomGeometry geometry = testing::phantom_1_0().geometry;
    const Vector3 q_rad(0.3, 0.2, -0.1);
    const TipPlace place = tip_place(geometry, q_rad);
    EXPECT_EQ(place.tip_m, tip_position_m(geometry, q_rad));
    EXPECT_EQ(place.jacobian_m_per_rad, joint_jacobian(geometry, q_rad));
}

} // namespace
} // namespace springdrive::device
