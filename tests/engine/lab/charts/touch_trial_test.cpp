// Covers engine/lab/charts/touch_trial.h.
#include "engine/lab/charts/touch_trial.h"

#include "engine/lab/rig/scenario/test_surfaces.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace springdrive::charts {
namespace {

constexpr std::size_t kTips = 3000;

TouchErrors proxy_errors(const TouchTrial &trial, const contact::HapticSurface &surface) {
    std::vector<RenderedTouch> touches(trial.tips.size());
    follow_with_proxy(surface, trial.tips, touches);
    return touch_errors(trial.tips, touches);
}

TouchErrors penalty_errors(const TouchTrial &trial, const contact::TriangleSoup &soup) {
    std::vector<RenderedTouch> touches(trial.tips.size());
    rig::ClosestPointFinder mesh(soup);
    push_to_closest_point(mesh, trial.tips, touches);
    return touch_errors(trial.tips, touches);
}

contact::HapticSurface primitive_of(const TouchTrial &trial) {
    contact::TriangleSoup material_only;
    material_only.materials = {{"primitive", 0.0}};
    return contact::HapticSurface(std::move(material_only), {*trial.primitive});
}

/// The largest angle at the centre between a triangle's normal and one of its corners.
double half_angle_rad(const contact::TriangleSoup &soup) {
    double largest = 0.0;
    for (const auto &[a, b, c] : soup.triangles) {
        const Vector3 &corner = soup.vertices_m[a];
        const Vector3 normal =
            (soup.vertices_m[b] - corner).cross(soup.vertices_m[c] - corner).normalized();
        largest = std::max(largest, std::acos(normal.dot(corner.normalized())));
    }
    return largest;
}

TEST(RenderedTouch, ErrorOnASphereMeshIsTheSagittaAndTheHalfAngle) {
    const TouchTrial trial = sphere_trial(kTips);
    for (const int divisions : {3, 4, 5}) {
        const contact::TriangleSoup soup = trial.mesh(divisions);
        const double angle = half_angle_rad(soup);
        for (const TouchErrors &errors :
             {proxy_errors(trial, contact::HapticSurface(soup)), penalty_errors(trial, soup)}) {
            const double sagitta_m = rig::kTestSphereRadius_m * (1.0 - std::cos(angle));
            EXPECT_LE(errors.depth_m, sagitta_m * (1.0 + 1e-9));
            EXPECT_GE(errors.depth_m, 0.5 * sagitta_m); // triangles differ by 1.2 in their edges
            EXPECT_LE(errors.direction_rad, angle * (1.0 + 1e-9));
            EXPECT_GE(errors.direction_rad, 0.5 * angle);
            EXPECT_FALSE(errors.pops_through);
        }
    }
}

TEST(RenderedTouch, ErrorsFallWithTheTriangles) {
    // Depths as 1/N, directions as 1/√N: four times the triangles are a quarter and a half.
    for (const TouchTrial &trial : {sphere_trial(kTips), organic_trial(kTips)}) {
        const TouchErrors coarse = proxy_errors(trial, contact::HapticSurface(trial.mesh(4)));
        const TouchErrors fine = proxy_errors(trial, contact::HapticSurface(trial.mesh(5)));
        EXPECT_NEAR(std::log2(coarse.depth_m / fine.depth_m), 2.0, 0.25) << trial.what;
        EXPECT_NEAR(std::log2(coarse.direction_rad / fine.direction_rad), 1.0, 0.25) << trial.what;
    }
}

TEST(RenderedTouch, OfAPrimitiveIsExact) {
    const TouchErrors errors = proxy_errors(sphere_trial(kTips), primitive_of(sphere_trial(1)));
    EXPECT_LT(errors.depth_m, 1e-16); // round-off of 50 mm
    EXPECT_LT(errors.direction_rad, 1e-7);
    const TouchErrors plate =
        proxy_errors(thin_plate_trial(kTips), primitive_of(thin_plate_trial(1)));
    EXPECT_LT(plate.depth_m, 1e-16);
}

TEST(RenderedTouch, OnACurvedMeshFollowsItsNormals) {
    const TouchTrial trial = sphere_trial(kTips);
    const contact::TriangleSoup coarse = trial.mesh(3);
    const TouchErrors flat = proxy_errors(trial, contact::HapticSurface(coarse));
    const TouchErrors curved =
        proxy_errors(trial, contact::HapticSurface(bent(coarse, trial.normal)));
    EXPECT_LT(curved.depth_m, 0.02 * flat.depth_m);
    // Half of the allowed difference of 0.5 degrees between neighbouring facets, except at corners.
    EXPECT_LT(curved.direction_rad, 0.5 * std::numbers::pi / 180.0);
}

TEST(RenderedTouch, PenaltyPopsThroughBeyondTheMiddleAndTheProxyNever) {
    const Vector3 half_m = rig::thin_plate_half_size_m();
    for (const double beyond_m : {-1e-6, 1e-6}) {
        TouchTrial trial = thin_plate_trial(1);
        const Vector3 top_m(0.01, half_m.y(), 0.005);
        trial.tips = {
            {top_m - (half_m.y() + beyond_m) * Vector3::UnitY(), top_m, Vector3::UnitY()}};
        EXPECT_EQ(penalty_errors(trial, trial.mesh(3)).pops_through, beyond_m > 0.0);
        EXPECT_FALSE(proxy_errors(trial, contact::HapticSurface(trial.mesh(3))).pops_through);
    }
}

TEST(RenderedTouch, ErrorOfAMissedContactIsItsWholeDepth) {
    const std::vector<rig::PressedTip> tips = rig::tips_in_sphere(10);
    const std::vector<RenderedTouch> nothing(tips.size());
    const TouchErrors errors = touch_errors(tips, nothing);
    double deepest_m = 0.0;
    for (const rig::PressedTip &tip : tips) {
        deepest_m = std::max(deepest_m, tip.depth_m());
    }
    EXPECT_DOUBLE_EQ(errors.depth_m, deepest_m); // rank 10 of 10
    EXPECT_EQ(errors.direction_rad, 0.0);
}

TEST(RenderedTouch, TrialsHaveTheStatedNumberOfTriangles) {
    EXPECT_EQ(sphere_trial(1).mesh(kCoarsestDivisions).triangles.size(), 1280U);
    EXPECT_EQ(thin_plate_trial(1).mesh(kCoarsestDivisions).triangles.size(), 768U);
    const contact::MeshReport report = contact::HapticSurface(thin_plate_trial(1).mesh(3)).report();
    EXPECT_EQ(report.closed_components, 1U);
    EXPECT_EQ(report.inward_components, 0U);
}

} // namespace
} // namespace springdrive::charts
