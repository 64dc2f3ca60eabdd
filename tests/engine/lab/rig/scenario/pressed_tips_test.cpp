// Covers engine/lab/rig/scenario/pressed_tips.cpp.
#include "engine/lab/rig/scenario/pressed_tips.h"

#include "engine/lab/rig/scenario/blob_shape.h"
#include "engine/lab/rig/scenario/test_surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>

namespace springdrive::rig {
namespace {

TEST(PressedTips, AreAsDeepAsTheySayUnderTheSphere) {
    for (const PressedTip &tip : tips_in_sphere(5000)) {
        ASSERT_NEAR(tip.tip_m.norm(), kTestSphereRadius_m - tip.depth_m(), 1e-16);
        ASSERT_NEAR(tip.surface_m.norm(), kTestSphereRadius_m, 1e-16);
        ASSERT_GE(tip.depth_m(), 0.999e-3);
        ASSERT_LE(tip.depth_m(), 2.001e-3);
    }
}

/// Points of the organic surface, some 0.6 mm from one to the next.
std::vector<Vector3> organic_points_m() {
    std::vector<Vector3> points_m;
    for (const Vector3 &vertex_m : organic_surface(6, kTestOrganicScale_m).vertices_m) {
        points_m.push_back(vertex_m);
    }
    return points_m;
}

TEST(PressedTips, OfTheOrganicShapeKnowTheNearestPointOfAll) {
    const std::vector<Vector3> points_m = organic_points_m();
    const std::vector<PressedTip> tips = tips_in_organic_shape(20'000);
    for (std::size_t i = 0; i < tips.size(); i += 97) {
        const PressedTip &tip = tips[i];
        double min_m = std::numeric_limits<double>::infinity();
        for (const Vector3 &point_m : points_m) {
            min_m = std::min(min_m, (point_m - tip.tip_m).norm());
        }
        ASSERT_GE(min_m, tip.depth_m() - 1e-15) << i;  // no point of the true surface is nearer
        ASSERT_LE(min_m, tip.depth_m() + 0.3e-3) << i; // and some of these are about as near
        ASSERT_NEAR(organic_shape().field(tip.surface_m / kTestOrganicScale_m),
                    organic_shape().level, 1e-12);
    }
}

TEST(PressedTips, MoveOnAsAHandDoes) {
    for (const auto &tips : {tips_in_sphere(20'000), tips_in_organic_shape(20'000)}) {
        double way_m = 0.0;
        for (std::size_t i = 1; i < tips.size(); ++i) {
            const double step_m = (tips[i].tip_m - tips[i - 1].tip_m).norm();
            ASSERT_LT(step_m, 0.4e-3);
            way_m += step_m;
        }
        EXPECT_NEAR(way_m / 20.0, 0.1, 0.05); // m/s at 1 kHz
    }
}

TEST(PressedTips, GoBeyondTheMiddleOfThePlateButNotThrough) {
    const Vector3 half_m = thin_plate_half_size_m();
    double min_m = half_m.y();
    for (const PressedTip &tip : tips_in_thin_plate(20'000)) {
        ASSERT_EQ(tip.surface_m.y(), half_m.y());
        ASSERT_LT(tip.tip_m.cwiseAbs().maxCoeff(), 0.8 * half_m.x());
        min_m = std::min(min_m, tip.tip_m.y());
    }
    EXPECT_NEAR(min_m, -0.5 * half_m.y(), 1e-6);
}

} // namespace
} // namespace springdrive::rig
