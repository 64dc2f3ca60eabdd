// Covers app/view/linkage_solids.cpp: no part of the linkage passes through
// another.
#include "app/view/linkage_solids.h"

#include "tests/support/devices.h"

#include <Eigen/Geometry>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

/// Inside the unit shape by more than float's rounding of coordinates; see
/// shapes.h.
bool is_inside(Shape shape, const glm::vec4 &at) {
    constexpr float kInside = 1.0F - 1e-4F;
    const float across = std::hypot(at.x, at.y);
    if (shape == Shape::ball) {
        return std::hypot(across, at.z) < kInside;
    }
    const float radius = shape == Shape::taper ? 1.0F + at.z * (kTaperEnd - 1.0F) : 1.0F;
    return at.z > 1.0F - kInside && at.z < kInside && across < kInside * radius;
}

/// Points all over the surface, in the world.
/// its length.
std::vector<glm::vec4> surface_points(const Solid &solid) {
    constexpr int kAroundShape = 16;
    constexpr int kAlongShape = 40;
    std::vector<glm::vec4> points;
    for (int row = 0; row <= kAlongShape; ++row) {
        for (int column = 0; column < kAroundShape; ++column) {
            const float angle =
                2.0F * std::numbers::pi_v<float> * static_cast<float>(column) / kAroundShape;
            const float along = static_cast<float>(row) / kAlongShape;
            float radius = solid.shape == Shape::taper ? 1.0F + along * (kTaperEnd - 1.0F) : 1.0F;
            float z = along;
            if (solid.shape == Shape::ball) {
                z = 2.0F * along - 1.0F;
                radius = std::sqrt(std::max(0.0F, 1.0F - z * z));
            }
            points.push_back(solid.model * glm::vec4(radius * std::cos(angle),
                                                     radius * std::sin(angle), z, 1.0F));
        }
    }
    return points;
}

/// A joint's axis, about which two parts meet, and how far from it.
struct Joint {
    Vector3 at_m{Vector3::Zero()};
    double radius_m = 0.0;
};

/// Where a pair may meet: not at all where the radius is 0. The radii are those
/// of the drums and pins of linkage_solids.cpp, with a tenth of a millimetre
/// for facets and rounding.
Joint joint_of(LinkagePart a, LinkagePart b, const device::LinkagePose &pose) {
    using enum LinkagePart;
    const auto is = [&](LinkagePart first, LinkagePart second) {
        return (a == first && b == second) || (a == second && b == first);
    };
    if (is(base, upper_arm) || is(base, crank)) {
        return {pose.base_m, 0.0171};
    }
    if (is(upper_arm, forearm)) {
        return {pose.elbow_m, 0.0086};
    }
    if (is(crank, rod)) {
        return {pose.crank_m, 0.0049};
    }
    if (is(rod, forearm)) {
        return {pose.coupling_m, 0.0049};
    }
    return {};
}

Vector3 axis_of(double q1_rad) { return {std::cos(q1_rad), 0.0, -std::sin(q1_rad)}; }

class Linkage : public ::testing::TestWithParam<device::DeviceDescription> {};

TEST_P(Linkage, NoPartPassesThroughAnotherAwayFromTheirJoint) {
    const device::DeviceDescription &device = GetParam();
    const double floor_m = device.workspace.centre_m.y() - device.workspace.size_m.y() / 2.0;
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> share(-0.5, 0.5);
    std::set<std::pair<LinkagePart, LinkagePart>> met;
    int poses = 0;
    for (int trial = 0; poses < 60 && trial < 1000; ++trial) {
        const Vector3 tip_m =
            device.workspace.centre_m + device.workspace.size_m.cwiseProduct(
                                            Vector3(share(random), share(random), share(random)));
        const auto q_rad = device::joint_angles_rad(device.geometry, tip_m);
        if (!q_rad || !device.joint_limits.allow(*q_rad)) {
            continue;
        }
        ++poses;
        const device::LinkagePose pose = device::linkage_pose(device.geometry, *q_rad);
        const Vector3 axis = axis_of((*q_rad)[0]);
        const std::vector<LinkageSolid> parts = linkage_parts(pose, floor_m, false);
        for (const LinkageSolid &one : parts) {
            const std::vector<glm::vec4> points = surface_points(one.solid);
            for (const LinkageSolid &other : parts) {
                if (one.part == other.part) {
                    continue;
                }
                const Joint joint = joint_of(one.part, other.part, pose);
                const glm::mat4 to_shape = glm::inverse(other.solid.model);
                for (const glm::vec4 &point : points) {
                    if (!is_inside(other.solid.shape, to_shape * point)) {
                        continue;
                    }
                    met.insert(std::minmax(one.part, other.part));
                    const Vector3 offset_m = Vector3(point.x, point.y, point.z) - joint.at_m;
                    const double from_axis_m = (offset_m - offset_m.dot(axis) * axis).norm();
                    ASSERT_LT(from_axis_m, joint.radius_m)
                        << "part " << static_cast<int>(one.part) << " is inside part "
                        << static_cast<int>(other.part) << " with the tip at " << tip_m.transpose();
                }
            }
        }
    }
    EXPECT_EQ(poses, 60);
    // Not vacuous: what shares a joint was found to meet; the crank's hub touches
    // the motors only.
    EXPECT_EQ(met.size(), 4U);
}

INSTANTIATE_TEST_SUITE_P(Devices, Linkage,
                         ::testing::Values(testing::phantom_1_0(), testing::phantom_premium_1_5()));

} // namespace
} // namespace springdrive::app
