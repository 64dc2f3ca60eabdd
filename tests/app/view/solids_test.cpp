// Covers app/view/shapes.cpp, solids.cpp, linkage_solids.cpp and marker_solids.cpp.
#include "app/view/linkage_solids.h"
#include "app/view/marker_solids.h"

#include "app/view/gl_vector.h"
#include "tests/support/devices.h"
#include "tests/support/framed_box.h"

#include <Eigen/Geometry>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

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

class Markers : public ::testing::Test {
protected:
    Markers() {
        camera =
            testing::framed_box(Vector3(-0.1, -0.1, -0.1), Vector3(0.1, 0.1, 0.1), {880.0, 520.0});
        state.touching = true;
        state.proxy_m = Vector3(0.02, 0.03, -0.01);
        state.normal = Vector3(2.0, 3.0, 6.0) / 7.0;
        state.tip_m = state.proxy_m - 0.004 * state.normal;
        state.tip_force_N = Vector3(1.0, 2.0, 2.0);
    }
    [[nodiscard]] std::vector<Solid> solids() const {
        return marker_solids(state, MarkerScale{camera, 520.0, 1.0});
    }

    Camera camera;
    ViewState state;
};

TEST_F(Markers, ArrowStandsOnTheProxyAndIsAsLongAsTheForce) {
    const Solid head = only_one(solids(), Shape::cone);
    const Vector3 expected_m = state.proxy_m + kArrowMetresPerNewton * state.tip_force_N;
    EXPECT_LT((end_of(head) - expected_m).norm(), kFloat_m);
    // The neck is on the way.
    const Vector3 neck_m = start_of(head) - state.proxy_m;
    EXPECT_LT(neck_m.cross(state.tip_force_N.normalized()).norm(), kFloat_m);
}

TEST_F(Markers, ArrowStandsOnTheTipInFreeSpace) {
    state.touching = false;
    const std::vector<Solid> drawn = solids();
    const Vector3 expected_m = state.tip_m + kArrowMetresPerNewton * state.tip_force_N;
    EXPECT_LT((end_of(only_one(drawn, Shape::cone)) - expected_m).norm(), kFloat_m);
    EXPECT_TRUE(std::none_of(drawn.begin(), drawn.end(),
                             [](const Solid &solid) { return solid.shape == Shape::ball; }));
}

TEST_F(Markers, ThereIsNoArrowWithoutAForceOrWithOneThatIsNoNumber) {
    for (const Vector3 &force_N :
         {Vector3(Vector3::Zero()),
          Vector3(Vector3::Constant(std::numeric_limits<double>::quiet_NaN()))}) {
        state.tip_force_N = force_N;
        for (const Solid &solid : solids()) {
            ASSERT_NE(solid.shape, Shape::cone);
            ASSERT_TRUE(start_of(solid).allFinite());
        }
    }
}

TEST_F(Markers, BallsKeepALegibleSizeFromAfar) {
    camera.zoom(-15.0, camera.target_m());
    const Solid proxy = only_one(solids(), Shape::ball);
    const double radius_m = (end_of(proxy) - start_of(proxy)).norm();
    EXPECT_GT(radius_m, kProxyRadius_m);
    EXPECT_GT(radius_m / camera.metres_per_pixel(state.proxy_m, 520.0), 3.0);
}

TEST_F(Markers, TargetRingFacesTheCamera) {
    camera.orbit(123.0, 45.0);
    const Solid target = only_one(solids(), Shape::ring);
    const Vector3 axis = (end_of(target) - start_of(target)).normalized();
    EXPECT_NEAR(std::abs(axis.dot(camera.forward())), 1.0, 1e-5);
}

} // namespace
} // namespace springdrive::app
