// Covers app/view/solids.cpp and app/view/linkage_solids.cpp: shapes, where they are placed, and
// that no part of the linkage passes through another.
#include "app/view/linkage_solids.h"

#include "app/view/gl_vector.h"
#include "tests/support/devices.h"

#include <Eigen/Geometry>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

constexpr double kFloat_m = 1e-6; // of coordinates below a metre in float, summed a few times

glm::vec3 to_vec3(const std::array<float, 3> &v) { return {v[0], v[1], v[2]}; }

/// The position of a point of the unit shape in the world.
Vector3 placed(const Solid &solid, const glm::vec3 &point) {
    return to_vector3(glm::vec3(solid.model * glm::vec4(point, 1.0F)));
}

Vector3 start_of(const Solid &solid) { return placed(solid, {0.0F, 0.0F, 0.0F}); }
Vector3 end_of(const Solid &solid) { return placed(solid, {0.0F, 0.0F, 1.0F}); }

Solid only_one(const std::vector<Solid> &solids, Shape shape) {
    const auto is_it = [&](const Solid &solid) { return solid.shape == shape; };
    EXPECT_EQ(std::count_if(solids.begin(), solids.end(), is_it), 1);
    const auto found = std::find_if(solids.begin(), solids.end(), is_it);
    return found == solids.end() ? Solid{} : *found;
}

class EveryShape : public ::testing::TestWithParam<Shape> {};

TEST_P(EveryShape, IsWoundOutwardAlongItsNormals) {
    const ShapeMesh mesh = make_shape(GetParam());
    int with_area = 0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const scene::VisualVertex &a = mesh.vertices.at(mesh.indices[i]);
        const scene::VisualVertex &b = mesh.vertices.at(mesh.indices[i + 1]);
        const scene::VisualVertex &c = mesh.vertices.at(mesh.indices[i + 2]);
        const glm::vec3 area = glm::cross(to_vec3(b.position_m) - to_vec3(a.position_m),
                                          to_vec3(c.position_m) - to_vec3(a.position_m));
        if (glm::length(area) < 1e-5F) {
            continue; // at a pole
        }
        ++with_area;
        for (const scene::VisualVertex *corner : {&a, &b, &c}) {
            ASSERT_NEAR(glm::length(to_vec3(corner->normal)), 1.0F, 1e-5F);
            ASSERT_GT(glm::dot(area, to_vec3(corner->normal)), 0.0F);
        }
    }
    EXPECT_GT(with_area, 40);
}

/// Divergence theorem: the volume within is a third of the flux of the position.
TEST_P(EveryShape, EnclosesItsVolume) {
    const ShapeMesh mesh = make_shape(GetParam());
    double volume = 0.0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::vec3 a = to_vec3(mesh.vertices[mesh.indices[i]].position_m);
        const glm::vec3 b = to_vec3(mesh.vertices[mesh.indices[i + 1]].position_m);
        const glm::vec3 c = to_vec3(mesh.vertices[mesh.indices[i + 2]].position_m);
        volume += static_cast<double>(glm::dot(a, glm::cross(b, c))) / 6.0;
    }
    constexpr double kPi = std::numbers::pi;
    const auto end = static_cast<double>(kTaperEnd);
    const double half_thickness = static_cast<double>(kRingThickness) / 2.0;
    double expected = 0.0;
    switch (GetParam()) {
    case Shape::ball:
        expected = 4.0 / 3.0 * kPi;
        break;
    case Shape::cylinder:
        expected = kPi;
        break;
    case Shape::taper:
        expected = kPi / 3.0 * (1.0 + end + end * end);
        break;
    case Shape::cone:
        expected = kPi / 3.0;
        break;
    case Shape::ring:
        expected = 2.0 * kPi * kPi * half_thickness * half_thickness;
        break;
    }
    // Facets lie inside: an octagon, the coarsest outline here, has 0.90 of its circle's area.
    EXPECT_LT(volume, expected);
    EXPECT_GT(volume, 0.88 * expected);
}

INSTANTIATE_TEST_SUITE_P(All, EveryShape, ::testing::ValuesIn(kShapes));

TEST(Spindle, RunsFromPointToPointAtItsRadiusUnmirrored) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> coordinate(-0.3, 0.3);
    for (int i = 0; i < 200; ++i) {
        const Vector3 from_m(coordinate(random), coordinate(random), coordinate(random));
        const Vector3 to_m(coordinate(random), coordinate(random), coordinate(random));
        const Solid solid = spindle(Shape::cylinder, from_m, to_m, 0.02, kForceColour);
        ASSERT_LT((start_of(solid) - from_m).norm(), kFloat_m);
        ASSERT_LT((end_of(solid) - to_m).norm(), kFloat_m);
        const Vector3 side_m = placed(solid, {0.6F, 0.8F, 0.0F}) - from_m;
        ASSERT_NEAR(side_m.norm(), 0.02, kFloat_m);
        ASSERT_NEAR(side_m.dot((to_m - from_m).normalized()), 0.0, kFloat_m);
        ASSERT_GT(glm::determinant(glm::mat3(solid.model)), 0.0F);
    }
}

TEST(Spindle, PointsOfSolidsAreWhereTheyAreDrawn) {
    const std::vector<Solid> solids{
        spindle(Shape::cylinder, {0.0, 0.1, 0.0}, {0.0, 0.4, 0.0}, 0.02, kTipColour)};
    Vector3 lower_m = Vector3::Constant(1e9);
    Vector3 upper_m = Vector3::Constant(-1e9);
    for (const Vector3 &point_m : drawn_points(solids)) {
        lower_m = lower_m.cwiseMin(point_m);
        upper_m = upper_m.cwiseMax(point_m);
    }
    EXPECT_LT((lower_m - Vector3(-0.02, 0.1, -0.02)).norm(), kFloat_m);
    EXPECT_LT((upper_m - Vector3(0.02, 0.4, 0.02)).norm(), kFloat_m);
}

TEST(LinkageSolids, ForearmRunsFromTheElbowToTheTip) {
    const device::PhantomGeometry geometry = testing::phantom_1_0().geometry;
    const device::LinkagePose pose = device::linkage_pose(geometry, Vector3(0.3, 0.2, -0.15));
    const Solid forearm = only_one(linkage_solids(pose, -0.06, false), Shape::taper);
    EXPECT_LT((start_of(forearm) - pose.elbow_m).norm(), kFloat_m);
    EXPECT_LT((end_of(forearm) - pose.tip_m).norm(), kFloat_m);
}

TEST(LinkageSolids, AreFiniteWhereTheLinkageIsSingularToo) {
    const device::PhantomGeometry geometry = testing::phantom_1_0().geometry;
    constexpr double kRightAngle = std::numbers::pi / 2.0;
    for (const Vector3 &q : {Vector3(0.0, 0.0, kRightAngle), Vector3(0.0, kRightAngle, 0.0),
                             Vector3(0.5, 0.0, -kRightAngle)}) {
        const device::LinkagePose pose = device::linkage_pose(geometry, q);
        for (const Solid &solid : linkage_solids(pose, -0.06, false)) {
            ASSERT_TRUE(start_of(solid).allFinite() && end_of(solid).allFinite());
            ASSERT_GT(glm::determinant(glm::mat3(solid.model)), 0.0F);
        }
    }
}

TEST(LinkageSolids, AreRedWhenTripped) {
    const device::PhantomGeometry geometry = testing::phantom_1_0().geometry;
    const device::LinkagePose pose = device::linkage_pose(geometry, Vector3::Zero());
    for (const Solid &solid : linkage_solids(pose, -0.06, true)) {
        EXPECT_GT(solid.colour.r, 2.0F * solid.colour.g);
        EXPECT_GT(solid.colour.r, 2.0F * solid.colour.b);
    }
}

/// Inside the unit shape by more than float's rounding of coordinates; see
/// solids.h.
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
