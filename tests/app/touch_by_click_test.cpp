// Covers app/view/pick.cpp, and app/stage/touch_by_click.cpp, which uses it.
#include "app/stage/touch_by_click.h"
#include "app/view/pick.h"
#include "app/view/view_state.h"
#include "tests/support/framed_box.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <utility>
#include <vector>

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

const Vector3 kBoxLower_m(-0.03, -0.02, -0.025);
const Vector3 kBoxUpper_m(0.03, 0.01, 0.025);
constexpr double kFrame60_s = 1.0 / 60.0;

const contact::HapticSurface &box_surface() {
    static const contact::HapticSurface kSurface(testing::box_soup(kBoxLower_m, kBoxUpper_m));
    return kSurface;
}

TouchGround box_ground() {
    return {box_surface(), kBoxLower_m, kBoxUpper_m, {Vector3::Zero(), Vector3::Constant(0.2)}};
}

/// The distance to the box, negative inside.
double box_distance_m(const Vector3 &point_m) {
    const Vector3 beyond_m = (kBoxLower_m - point_m).cwiseMax(point_m - kBoxUpper_m);
    return beyond_m.cwiseMax(0.0).norm() + std::min(beyond_m.maxCoeff(), 0.0);
}

/// The same by slabs: where a way from outside enters the box.
std::optional<Vector3> box_entry_m(const Vector3 &from_m, const Vector3 &to_m) {
    double enters = 0.0;
    double leaves = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double way_m = to_m[axis] - from_m[axis];
        const double lower = (kBoxLower_m[axis] - from_m[axis]) / way_m;
        const double upper = (kBoxUpper_m[axis] - from_m[axis]) / way_m;
        enters = std::max(enters, std::min(lower, upper));
        leaves = std::min(leaves, std::max(lower, upper));
    }
    return enters < leaves ? std::optional<Vector3>(from_m + enters * (to_m - from_m))
                           : std::nullopt;
}

TEST(FirstTouchable, IsWhereAWayEntersABox) {
    constexpr double kReach_m = 1e-6; // of the search
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> place(-0.08, 0.08);
    int hits = 0;
    int from_inside = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vector3 from_m(place(random), place(random), place(random));
        const Vector3 to_m(place(random), place(random), place(random));
        const auto found = first_touchable(box_surface(), from_m, to_m);
        const auto entry_m = box_entry_m(from_m, to_m);
        if (box_distance_m(from_m) < kReach_m) {
            ++from_inside;
            EXPECT_FALSE(found); // a solid lets out
            continue;
        }
        ASSERT_EQ(found.has_value(), entry_m.has_value());
        if (found) {
            ++hits;
            // The search stops where it comes that near, earlier on a way that grazes.
            const double sine = std::abs((to_m - from_m).normalized().dot(found->normal));
            EXPECT_LT((found->point_m - *entry_m).norm(), 3.0 * kReach_m / sine);
            const Vector3 outside_m = found->point_m + 1e-3 * found->normal;
            EXPECT_NEAR(box_distance_m(outside_m), 1e-3, 1e-5);
        }
    }
    EXPECT_GT(hits, 200);
    EXPECT_GT(from_inside, 20);
}

TEST(PlaceBelow, IsTheSurfaceElseTheFloorElseNothing) {
    constexpr double kFloor_m = -0.09;
    const auto on_top = place_below(box_surface(), {0.01, 0.05, 0.01}, kFloor_m);
    ASSERT_TRUE(on_top);
    EXPECT_LT((on_top->point_m - Vector3(0.01, 0.01, 0.01)).norm(), 1e-9);
    EXPECT_NEAR(on_top->normal.y(), 1.0, 1e-9);
    const auto beside = place_below(box_surface(), {0.05, 0.05, 0.01}, kFloor_m);
    ASSERT_TRUE(beside);
    EXPECT_LT((beside->point_m - Vector3(0.05, kFloor_m, 0.01)).norm(), 1e-9);
    EXPECT_FALSE(place_below(box_surface(), {0.05, -0.1, 0.01}, kFloor_m));
    EXPECT_FALSE(place_below(box_surface(), Vector3::Constant(NAN), kFloor_m));
}

TEST(WayRound, PassesTheBoxWithoutTouchingIt) {
    const std::vector<std::pair<Vector3, Vector3>> ways{
        {{0.0, 0.05, 0.0}, {0.0, -0.04, 0.0}},    // to the side below
        {{-0.06, 0.0, 0.0}, {0.06, 0.0, 0.0}},    // from left to right
        {{0.0, 0.0, 0.05}, {0.0, 0.0, -0.05}},    // from front to back
        {{0.005, -0.035, 0.0}, {0.01, 0.03, 0.0}} // out from below
    };
    for (const auto &[from_m, to_m] : ways) {
        ASSERT_TRUE(box_entry_m(from_m + Vector3::Constant(1e-9), to_m)); // something is there
        Vector3 at_m = from_m;
        for (const Vector3 &next_m : way_round(box_ground(), from_m, to_m)) {
            for (int i = 0; i <= 100; ++i) {
                EXPECT_GT(box_distance_m(at_m + 0.01 * i * (next_m - at_m)), 1.9e-3);
            }
            at_m = next_m;
        }
        EXPECT_EQ(at_m, to_m);
    }
    const Vector3 beside_m(0.0, 0.06, 0.03);
    EXPECT_EQ(way_round(box_ground(), {0.0, 0.05, 0.0}, beside_m), std::vector<Vector3>{beside_m});
}

const SurfacePlace kOnTop{{0.01, 0.01, -0.005}, Vector3::UnitY()};
const Vector3 kStart_m(-0.02, 0.06, 0.02);

/// That of a tip pressed into the upper side.
contact::Contact touching_at(const SurfacePlace &place) {
    contact::Contact contact;
    contact.touching = true;
    contact.x0_m = place.point_m;
    contact.normal = place.normal;
    return contact;
}

TEST(TouchByClick, ComesDownAlongTheNormalAtBoundedSpeedAndStaysAtTheStatedDepth) {
    TouchByClick touch;
    touch.press(box_ground(), {}, kStart_m, kOnTop);
    Vector3 at_m = kStart_m;
    double below_s = 0.0;
    for (int frame = 0; frame < 120; ++frame) {
        ASSERT_TRUE(touch.is_on());
        const Vector3 next_m = touch.next_m(kFrame60_s);
        EXPECT_LE((next_m - at_m).norm(), 0.25 * kFrame60_s * (1.0 + 1e-9));
        if (next_m.y() < kOnTop.point_m.y() + 0.014) { // 15 mm above, it turns
            EXPECT_LT((next_m - kOnTop.point_m).cross(kOnTop.normal).norm(), 1e-9);
            EXPECT_LE((next_m - at_m).norm(), 0.06 * kFrame60_s * 1.001 + 1e-3 * (below_s == 0.0));
            below_s += kFrame60_s;
        }
        at_m = next_m;
    }
    EXPECT_LT((at_m - (kOnTop.point_m - 0.006 * kOnTop.normal)).norm(), 1e-12);
    EXPECT_TRUE(touch.is_pressed());
}

/// Lets it come down; where the hand is then.
Vector3 pressed_down(TouchByClick &touch) {
    touch.press(box_ground(), {}, kStart_m, kOnTop);
    Vector3 at_m = kStart_m;
    for (int frame = 0; frame < 120; ++frame) {
        at_m = touch.next_m(kFrame60_s);
    }
    return at_m;
}

TEST(TouchByClick, IsPressedDeeperByTheWheelWithinLimits) {
    TouchByClick touch;
    pressed_down(touch);
    for (const auto &[by_m, depth_m] : {std::pair(0.002, 0.008),
                                        {-0.004, 0.004},
                                        {1.0, TouchByClick::kDeepest_m},
                                        {-1.0, TouchByClick::kMin_m}}) {
        touch.deepen(by_m);
        Vector3 at_m = kStart_m;
        for (int frame = 0; frame < 80; ++frame) {
            at_m = touch.next_m(kFrame60_s);
        }
        EXPECT_NEAR(kOnTop.point_m.y() - at_m.y(), depth_m, 1e-12);
    }
}

TEST(TouchByClick, SlidesOnTheSurfaceAfterTheCursor) {
    TouchByClick touch;
    Vector3 at_m = pressed_down(touch);
    SurfacePlace there = kOnTop;
    there.point_m.x() -= 0.02;
    touch.aim(box_ground(), touching_at(kOnTop), there);
    for (int frame = 0; frame < 20; ++frame) {
        const Vector3 next_m = touch.next_m(kFrame60_s);
        EXPECT_LE((next_m - at_m).norm(), 0.15 * kFrame60_s * (1.0 + 1e-9));
        EXPECT_NEAR(next_m.y(), kOnTop.point_m.y() - 0.006, 1e-12);
        at_m = next_m;
    }
    EXPECT_LT((at_m - (there.point_m - 0.006 * there.normal)).norm(), 1e-12);
}

TEST(TouchByClick, GoesOffTheSurfaceAndRoundToAnotherSideOfIt) {
    TouchByClick touch;
    Vector3 at_m = pressed_down(touch);
    const SurfacePlace in_front{{0.01, -0.005, kBoxUpper_m.z()}, Vector3::UnitZ()};
    touch.aim(box_ground(), touching_at(kOnTop), in_front);
    bool was_off = false;
    for (int frame = 0; frame < 200; ++frame) {
        at_m = touch.next_m(kFrame60_s);
        was_off = was_off || at_m.y() > kOnTop.point_m.y() + 0.012; // of 0.015, between frames
        // It enters the box where it is aimed at, and nowhere else.
        if (was_off && box_distance_m(at_m) < 0.0) {
            EXPECT_LT((at_m - in_front.point_m).cross(in_front.normal).norm(), 1e-9);
        }
    }
    EXPECT_TRUE(was_off);
    EXPECT_LT((at_m - (in_front.point_m - 0.006 * in_front.normal)).norm(), 1e-12);
}

TEST(TouchByClick, LiftsOffWhenItIsLetGoAndStopsWhereItIsBeforeThat) {
    TouchByClick touch;
    Vector3 at_m = pressed_down(touch);
    touch.let_go(box_ground(), touching_at(kOnTop));
    EXPECT_TRUE(touch.is_on());
    EXPECT_FALSE(touch.is_pressed());
    int frames = 0;
    for (; touch.is_on() && frames < 100; ++frames) {
        at_m = touch.next_m(kFrame60_s);
    }
    EXPECT_LT((at_m - (kOnTop.point_m + 0.015 * kOnTop.normal)).norm(), 1e-12);
    EXPECT_LT(frames, 20); // 21 mm at 0.1 m/s
    touch.press(box_ground(), {}, kStart_m, kOnTop);
    (void)touch.next_m(kFrame60_s);
    touch.let_go(box_ground(), {}); // still in the air
    EXPECT_FALSE(touch.is_on());
}

} // namespace
} // namespace springdrive::app
