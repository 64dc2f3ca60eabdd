// Covers engine/lab/charts/motion_trial.h.
#include "engine/lab/charts/motion_trial.h"

#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/force_direction.h"
#include "engine/lab/loops/stiffness_ellipse.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::charts {
namespace {

constexpr MotionMethod kInverse{control::MotionMap::inverse, control::AlphaMode::on_the_fly, 0.0};
constexpr MotionMethod kOnTheFly{control::MotionMap::transpose, control::AlphaMode::on_the_fly,
                                 0.0};

MotionMethod by_hand(double alpha_rad2_per_m2) {
    return {control::MotionMap::transpose, control::AlphaMode::by_hand, alpha_rad2_per_m2};
}

TEST(MotionTrial, ErrorOfTheInverseIsAtMostQ3MinusQ2InTheLinksPlane) {
    // docs/design.md, "Linkage and motors": exact for l₁ = l₂ and N₂ = N₃, and small depths.
    const device::DeviceDescription device = testing::phantom_1_0();
    for (const Vector3 &q_deg : {Vector3(0, 20, -15), Vector3(10, -10, 25), Vector3(-20, 5, 5)}) {
        double largest = 0.0;
        for (int i = 0; i < 3600; ++i) {
            const loops::Vector2 n = loops::direction_at(std::numbers::pi * i / 3600.0);
            const Vector3 normal = loops::link_plane(kRadiansPerDegree * q_deg[0]) * n;
            const HeldTip tip{kRadiansPerDegree * q_deg, normal, 1e-7, 0};
            largest = std::max(
                largest, control::direction_error_rad(
                             force_on_holder_N(device, control::Tuning{}, kInverse, tip), normal));
        }
        EXPECT_NEAR(largest / kRadiansPerDegree, std::abs(q_deg[2] - q_deg[1]), 1e-3)
            << q_deg.transpose();
    }
}

TEST(MotionTrial, ErrorOfTheTransposeIsRoundOffAndTheEncodersQuantum) {
    for (const device::DeviceDescription &device :
         {testing::phantom_1_0(), testing::phantom_premium_1_5()}) {
        for (const Vector3 &q_rad : workspace_angles_rad(device, 4)) {
            for (const Vector3 &normal : spread_normals(10)) {
                const auto error_rad = [&](int counts) {
                    return control::direction_error_rad(
                        force_on_holder_N(device, control::Tuning{}, kOnTheFly,
                                          {q_rad, normal, 1e-3, counts}),
                        normal);
                };
                ASSERT_LT(error_rad(0), 1e-12);
                // Half a count at a joint is π/(4096·11); the links amplify it no more than
                // tenfold.
                ASSERT_LT(error_rad(4096), 10.0 * std::numbers::pi / (4096.0 * 11.0));
            }
        }
    }
}

TEST(MotionTrial, StiffnessIsThatOf27And21) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const Vector3 q_rad = kRadiansPerDegree * Vector3(0, 20, -15);
    const loops::PlanarStiffness known = loops::planar_stiffness(device, control::Tuning{}, q_rad);
    for (const double angle : {0.0, 0.7, 2.0}) {
        const loops::Vector2 n = loops::direction_at(angle);
        const HeldTip tip{q_rad, loops::link_plane(0.0) * n, 1e-7, 0};
        const double transpose = tip.normal.dot(
            force_on_holder_N(device, control::Tuning{}, by_hand(known.alpha_rad2_per_m2), tip));
        EXPECT_NEAR(transpose / tip.depth_m / known.transpose(0, 0), 1.0, 1e-6);
        const double inverse =
            tip.normal.dot(force_on_holder_N(device, control::Tuning{}, kInverse, tip));
        EXPECT_NEAR(inverse / tip.depth_m / n.dot(known.inverse * n), 1.0, 1e-6);
    }
}

TEST(MotionTrial, InverseWithoutASolutionGivesNoForce) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const Vector3 aligned_rad = kRadiansPerDegree * Vector3(0, -45, 45);
    EXPECT_TRUE(force_on_holder_N(device, control::Tuning{}, kInverse,
                                  {aligned_rad, Vector3::UnitY(), 1e-3, 0})
                    .isZero(0.0));
}

TEST(MotionTrial, StableUpToTheBoundAndUnstableFarAboveIt) {
    const device::DeviceDescription device = testing::phantom_1_0();
    for (const Vector3 &q_rad : workspace_angles_rad(device, 3)) {
        EXPECT_TRUE(is_stable_at(device, control::Tuning{}, kInverse, q_rad));
        EXPECT_TRUE(is_stable_at(device, control::Tuning{}, kOnTheFly, q_rad));
    }
    // One mode's loop gain grows with α: it becomes unstable at one α and remains so above it.
    const Vector3 q_rad = kRadiansPerDegree * Vector3(0, 20, -15);
    bool was_stable = true;
    for (int i = 0; i < 42; ++i) {
        const double alpha = 2000.0 * std::pow(1.1, i); // up to 1e5
        const bool stable = is_stable_at(device, control::Tuning{}, by_hand(alpha), q_rad);
        EXPECT_TRUE(was_stable || !stable) << alpha;
        was_stable = stable;
    }
    EXPECT_FALSE(was_stable);
}

TEST(MotionTrial, PlacesAreInReachAndNormalsEven) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const std::vector<Vector3> places_rad = workspace_angles_rad(device, 5);
    EXPECT_GT(places_rad.size(), 60U);
    for (const Vector3 &q_rad : places_rad) {
        EXPECT_TRUE(device.joint_limits.allow(q_rad));
    }
    Vector3 sum = Vector3::Zero();
    for (const Vector3 &normal : spread_normals(100)) {
        ASSERT_NEAR(normal.norm(), 1.0, 1e-15);
        sum += normal;
    }
    EXPECT_LT(sum.norm(), 2.0);
}

} // namespace
} // namespace springdrive::charts
