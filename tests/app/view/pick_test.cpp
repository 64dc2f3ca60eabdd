// Covers app/view/pick.cpp.
#include "app/view/pick.h"

#include "app/view/view_state.h"
#include "tests/support/framed_box.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace springdrive::app {
namespace {

constexpr double kPicked_m = 1e-6; // coordinates below a metre in float

TEST(Pick, HitsABallsFacetsJustInsideTheBallItself) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
    const Vector3 centre_m(0.1, -0.05, 0.2);
    constexpr double kRadius_m = 0.05;
    const std::vector<Solid> solids{ball(centre_m, kRadius_m, kTipColour)};
    int hits = 0;
    int misses = 0;
    for (int i = 0; i < 500; ++i) {
        const Vector3 origin_m =
            centre_m +
            Vector3(coordinate(random), coordinate(random), coordinate(random)).normalized();
        const Vector3 aim_m =
            centre_m + 0.08 * Vector3(coordinate(random), coordinate(random), coordinate(random));
        const Ray ray{origin_m, (aim_m - origin_m).normalized()};
        // |origin + t direction − centre| = radius
        const double middle_m = (centre_m - origin_m).dot(ray.direction);
        const double aside_m = (centre_m - origin_m - middle_m * ray.direction).norm();
        const std::optional<double> found_m = first_hit_m(ray, solids);
        // The facets' faces lie within the ball by at most 1 − cos(half of 15°) of the radius.
        const double inner_m =
            kRadius_m * std::cos(std::numbers::pi / 24.0) * std::cos(std::numbers::pi / 24.0);
        if (aside_m > kRadius_m + kPicked_m) {
            ++misses;
            ASSERT_FALSE(found_m.has_value());
        } else if (aside_m < inner_m - kPicked_m) {
            ++hits;
            ASSERT_TRUE(found_m.has_value());
            const double first_m = middle_m - std::sqrt(kRadius_m * kRadius_m - aside_m * aside_m);
            const double last_m = middle_m - std::sqrt(inner_m * inner_m - aside_m * aside_m);
            ASSERT_GT(*found_m, first_m - kPicked_m);
            ASSERT_LT(*found_m, last_m + kPicked_m);
        }
    }
    EXPECT_GT(hits, 50);
    EXPECT_GT(misses, 50);
}

TEST(Pick, TakesTheFirstOfSeveralAndNoneBehindTheOrigin) {
    const auto plate = [](float height_m) {
        scene::VisualMesh mesh;
        for (const auto &[x, z] : {std::pair{-1.0F, -1.0F}, {3.0F, -1.0F}, {-1.0F, 3.0F}}) {
            mesh.vertices.push_back({{x, height_m, z}, {0.0F, 1.0F, 0.0F}, {}, {}});
        }
        mesh.indices = {0, 1, 2};
        return mesh;
    };
    const std::vector<scene::VisualMesh> meshes{plate(0.0F), plate(0.25F), plate(2.0F)};
    const Ray down{{0.1, 1.0, 0.2}, -Vector3::UnitY()};
    EXPECT_NEAR(first_hit_m(down, meshes).value_or(-1.0), 0.75, kPicked_m);
    const Ray up{{0.1, 1.0, 0.2}, Vector3::UnitY()};
    EXPECT_NEAR(first_hit_m(up, meshes).value_or(-1.0), 1.0, kPicked_m);
    EXPECT_FALSE(first_hit_m(Ray{{0.1, 1.0, 0.2}, Vector3::UnitX()}, meshes).has_value());
    EXPECT_FALSE(first_hit_m(Ray{{-1.1, 1.0, 0.2}, -Vector3::UnitY()}, meshes).has_value());
}

TEST(Pick, FloorIsHitOnlyByWhatGoesTowardsIt) {
    const Ray down{{0.0, 0.5, 0.0}, Vector3(0.6, -0.8, 0.0)};
    EXPECT_NEAR(floor_hit_m(down, 0.1).value_or(-1.0), 0.5, 1e-12);
    EXPECT_FALSE(floor_hit_m(Ray{{0.0, 0.5, 0.0}, Vector3(0.6, 0.8, 0.0)}, 0.1).has_value());
    EXPECT_FALSE(floor_hit_m(Ray{{0.0, 0.5, 0.0}, Vector3::UnitX()}, 0.1).has_value());
}

TEST(Pick, LineOfSightGoesThroughItsPixel) {
    constexpr PixelSize kPickViewport{880.0, 485.0};
    const Camera camera =
        testing::framed_box(Vector3::Constant(-0.1), Vector3::Constant(0.1), kPickViewport);
    const PixelPoint pixel{123.0, 321.0};
    const Ray ray = line_of_sight(camera, pixel, kPickViewport);
    for (const double distance_m : {0.1, 0.5, 2.0}) {
        const std::optional<PixelPoint> seen =
            camera.pixel_of(ray.origin_m + distance_m * ray.direction, kPickViewport);
        ASSERT_TRUE(seen.has_value());
        EXPECT_NEAR(seen->x_px, pixel.x_px, 1e-8);
        EXPECT_NEAR(seen->y_px, pixel.y_px, 1e-8);
    }
}

} // namespace
} // namespace springdrive::app
