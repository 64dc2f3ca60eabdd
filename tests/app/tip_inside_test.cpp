// Covers app/demo/tip_inside.cpp: a point in a solid is told from one beside it, below an open mesh
// or in a bowl.
#include "app/demo/tip_inside.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <random>

namespace springdrive::app {
namespace {

/// Adds a box; `sides` of its six sides, the last of which is the one below.
void add_box(scene::Scene &scene, const Vector3 &lower_m, const Vector3 &upper_m, int sides = 6) {
    auto &soup = scene.surface;
    const auto first = static_cast<std::uint32_t>(soup.vertices_m.size());
    for (unsigned corner = 0; corner < 8; ++corner) {
        soup.vertices_m.emplace_back((corner & 1U) != 0U ? upper_m.x() : lower_m.x(),
                                     (corner & 2U) != 0U ? upper_m.y() : lower_m.y(),
                                     (corner & 4U) != 0U ? upper_m.z() : lower_m.z());
    }
    // Counter-clockwise from outside: right, left, above, front, back, below.
    constexpr std::array<std::array<std::uint32_t, 4>, 6> kSides{
        {{1, 3, 7, 5}, {0, 4, 6, 2}, {2, 6, 7, 3}, {4, 5, 7, 6}, {0, 2, 3, 1}, {0, 1, 5, 4}}};
    for (int side = 0; side < sides; ++side) {
        const auto &at = kSides[static_cast<std::size_t>(side)];
        soup.triangles.push_back({first + at[0], first + at[1], first + at[2]});
        soup.triangles.push_back({first + at[0], first + at[2], first + at[3]});
    }
    scene.lower_m = scene.lower_m.cwiseMin(lower_m);
    scene.upper_m = scene.upper_m.cwiseMax(upper_m);
}

const Vector3 kLower_m(-0.02, -0.03, -0.01);
const Vector3 kUpper_m(0.04, 0.01, 0.05);

TEST(TipInside, IsToldFromBesideABoxAtRandomAndRoundPlaces) {
    scene::Scene scene;
    add_box(scene, kLower_m, kUpper_m);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(-0.06, 0.06);
    int inside = 0;
    for (int i = 0; i < 2000; ++i) {
        Vector3 point(place(random), place(random), place(random));
        if (i % 2 == 1) { // on the box's diagonals and corners, in parts
            point = (100.0 * point).array().round() / 100.0;
        }
        const double beyond =
            std::max((kLower_m - point).maxCoeff(), (point - kUpper_m).maxCoeff());
        if (std::abs(beyond) < 1e-6) {
            continue; // on the surface
        }
        EXPECT_EQ(lies_inside(scene, point), beyond < 0.0) << point.transpose();
        inside += beyond < 0.0 ? 1 : 0;
    }
    EXPECT_GT(inside, 50);
}

TEST(TipInside, IsFalseInAnOpenBoxAndBelowASheet) {
    scene::Scene open;
    add_box(open, kLower_m, kUpper_m, 5);
    EXPECT_FALSE(lies_inside(open, Vector3::Zero()));
    scene::Scene sheet;
    sheet.surface.vertices_m = {{-0.1, 0.0, -0.1}, {-0.1, 0.0, 0.1}, {0.1, 0.0, 0.1}};
    sheet.surface.triangles = {{0, 1, 2}};
    sheet.lower_m = Vector3::Constant(-0.1);
    sheet.upper_m = Vector3::Constant(0.1);
    for (const double y : {-0.01, 0.01}) {
        EXPECT_FALSE(lies_inside(sheet, {-0.05, y, 0.0}));
    }
}

TEST(TipInside, KnowsHollowsAndOverlaps) {
    scene::Scene scene;
    add_box(scene, kLower_m, kUpper_m);
    add_box(scene, Vector3(0.03, -0.02, 0.0), Vector3(0.08, 0.0, 0.02)); // overlaps the first
    EXPECT_TRUE(lies_inside(scene, {0.035, -0.01, 0.01}));               // in both
    EXPECT_TRUE(lies_inside(scene, {0.06, -0.01, 0.01}));
    scene::Scene hollow;
    add_box(hollow, kLower_m, kUpper_m);
    add_box(hollow, Vector3::Constant(-0.005), Vector3::Constant(0.005));
    for (std::size_t i = 12; i < 24; ++i) { // the walls of a hollow face it
        std::swap(hollow.surface.triangles[i][1], hollow.surface.triangles[i][2]);
    }
    EXPECT_FALSE(lies_inside(hollow, {0.001, 0.002, 0.001}));
    EXPECT_TRUE(lies_inside(hollow, {0.001, -0.01, 0.001}));
}

TEST(TipInside, KnowsSolidShapes) {
    scene::Scene scene;
    scene.shapes.emplace_back(contact::Sphere{0.02},
                              Eigen::Isometry3d(Eigen::Translation3d(0.01, 0.0, 0.0)),
                              std::uint16_t{0});
    EXPECT_TRUE(lies_inside(scene, {0.0299, 0.0, 0.0}));
    EXPECT_FALSE(lies_inside(scene, {0.0301, 0.0, 0.0}));
}

TEST(TipInside, IsComputedAnewForAnotherSceneOrPlaceButNotAllTheTime) {
    scene::Scene box;
    add_box(box, kLower_m, kUpper_m);
    const scene::Scene empty;
    TipInside inside;
    const Vector3 out_m(0.0, 0.1, 0.0);
    EXPECT_TRUE(inside.at(box, 1, Vector3::Zero(), 0.0));
    EXPECT_TRUE(inside.at(box, 1, out_m, 0.1)); // not yet
    EXPECT_FALSE(inside.at(box, 1, out_m, 0.3));
    EXPECT_FALSE(inside.at(box, 1, Vector3::Zero(), 0.4));
    EXPECT_TRUE(inside.at(box, 1, Vector3::Zero(), 0.6));
    EXPECT_FALSE(inside.at(empty, 2, Vector3::Zero(), 0.61)); // at once
    EXPECT_FALSE(inside.at(box, 3, Vector3::Constant(std::nan("")), 0.7));
}

} // namespace
} // namespace springdrive::app
