// Covers app/view/camera.cpp.
#include "app/view/camera.h"

#include "app/view/gl_vector.h"
#include "tests/support/framed_box.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace springdrive::app {
namespace {

constexpr PixelSize kViewport{880.0, 520.0};

// The camera computes in double; only results of GL's float matrices are less accurate. A
// coordinate of up to some 10 m in float is accurate to 1e-6 m, which is 1e-3 px where a pixel is 1
// mm.
constexpr double kExact = 1e-10;
constexpr double kFloatPixel_px = 0.05;

class RandomViews {
public:
    explicit RandomViews(std::uint64_t seed) : random_(seed) {}

    double between(double minimum, double maximum) {
        return std::uniform_real_distribution<double>(minimum, maximum)(random_);
    }

    Vector3 point(double reach_m) {
        return {between(-reach_m, reach_m), between(-reach_m, reach_m), between(-reach_m, reach_m)};
    }

    /// After all actions of a user.
    Camera camera() {
        const Vector3 centre_m = point(0.1);
        const Vector3 half_m(between(0.05, 0.3), between(0.05, 0.3), between(0.05, 0.3));
        Camera camera = testing::framed_box(centre_m - half_m, centre_m + half_m, kViewport);
        camera.orbit(between(-900.0, 900.0), between(-200.0, 200.0));
        camera.pan(between(-100.0, 100.0), between(-100.0, 100.0), kViewport.height_px);
        camera.zoom(between(-5.0, 10.0), camera.target_m() + point(0.1));
        return camera;
    }

private:
    std::mt19937_64 random_;
};

/// Normalised device coordinates, as OpenGL computes them.
glm::vec3 device_coordinates(const Camera &camera, double aspect, const Vector3 &point_m) {
    const glm::vec4 clip =
        camera.projection(aspect) * camera.view() * glm::vec4(to_glm(point_m), 1.0F);
    return glm::vec3(clip) / clip.w;
}

TEST(Camera, AxesAreUnitAndRightHanded) {
    RandomViews random(1);
    for (int i = 0; i < 200; ++i) {
        const Camera camera = random.camera();
        ASSERT_NEAR(camera.right().norm(), 1.0, kExact);
        ASSERT_NEAR(camera.up().norm(), 1.0, kExact);
        ASSERT_LT((camera.right().cross(camera.up()) + camera.forward()).norm(), kExact);
    }
}

TEST(Camera, NeverRolls) {
    RandomViews random(2);
    for (int i = 0; i < 200; ++i) {
        const Camera camera = random.camera();
        ASSERT_NEAR(camera.right().y(), 0.0, kExact);
        ASSERT_GT(camera.up().y(), 0.0);
    }
}

TEST(Camera, PixelOfAPointIsWhereOpenGLDrawsIt) {
    RandomViews random(3);
    int seen = 0;
    for (int i = 0; i < 500; ++i) {
        const Camera camera = random.camera();
        const Vector3 point_m = camera.target_m() + random.point(0.2 * camera.distance_m());
        const std::optional<PixelPoint> pixel = camera.pixel_of(point_m, kViewport);
        ASSERT_TRUE(pixel.has_value());
        const glm::vec3 drawn = device_coordinates(camera, kViewport.aspect(), point_m);
        ASSERT_NEAR(pixel->x_px, (1.0 + static_cast<double>(drawn.x)) / 2.0 * kViewport.width_px,
                    kFloatPixel_px);
        ASSERT_NEAR(pixel->y_px, (1.0 - static_cast<double>(drawn.y)) / 2.0 * kViewport.height_px,
                    kFloatPixel_px);
        seen += std::abs(drawn.x) < 1.0F && std::abs(drawn.y) < 1.0F ? 1 : 0;
    }
    EXPECT_GT(seen, 400); // not vacuous: most are on the screen
}

TEST(Camera, PointUnderAPixelIsSeenAtThatPixel) {
    RandomViews random(4);
    for (int i = 0; i < 500; ++i) {
        const Camera camera = random.camera();
        const Vector3 at_m = camera.target_m() + random.point(0.3 * camera.distance_m());
        const PixelPoint pixel{random.between(0.0, kViewport.width_px),
                               random.between(0.0, kViewport.height_px)};
        const Vector3 point_m = camera.point_at(pixel, kViewport, at_m);
        // In the view plane through at_m:
        ASSERT_NEAR((point_m - at_m).dot(camera.forward()), 0.0, kExact);
        const std::optional<PixelPoint> back = camera.pixel_of(point_m, kViewport);
        ASSERT_TRUE(back.has_value());
        // Hundreds of pixels, each with a rounding error of some 1e-16 of the distance.
        ASSERT_NEAR(back->x_px, pixel.x_px, 1e-8);
        ASSERT_NEAR(back->y_px, pixel.y_px, 1e-8);
    }
}

TEST(Camera, PointThroughItsOwnPixelComesBack) {
    RandomViews random(5);
    for (int i = 0; i < 500; ++i) {
        const Camera camera = random.camera();
        const Vector3 point_m = camera.target_m() + random.point(0.4 * camera.distance_m());
        const std::optional<PixelPoint> pixel = camera.pixel_of(point_m, kViewport);
        ASSERT_TRUE(pixel.has_value());
        ASSERT_LT((camera.point_at(*pixel, kViewport, point_m) - point_m).norm(), kExact);
    }
}

TEST(Camera, PointsBehindTheEyeHaveNoPixel) {
    RandomViews random(6);
    for (int i = 0; i < 100; ++i) {
        const Camera camera = random.camera();
        EXPECT_FALSE(camera.pixel_of(camera.eye_m(), kViewport).has_value());
        EXPECT_FALSE(
            camera.pixel_of(camera.eye_m() - 0.1 * camera.forward(), kViewport).has_value());
    }
}

TEST(Camera, MetresPerPixelIsTheProjectionsSlope) {
    RandomViews random(7);
    // A step of 0.1 of the depth: float round-off in the quotient stays below 1e-5, and within a
    // view plane the projection is linear, so that there is no truncation.
    constexpr double kRelative = 1e-4;
    for (int i = 0; i < 500; ++i) {
        const Camera camera = random.camera();
        const Vector3 at_m = camera.target_m() + random.point(0.2 * camera.distance_m());
        const double step_m = 0.1 * camera.distance_m();
        const glm::vec3 here = device_coordinates(camera, kViewport.aspect(), at_m);
        const glm::vec3 above =
            device_coordinates(camera, kViewport.aspect(), at_m + step_m * camera.up());
        const glm::vec3 beside =
            device_coordinates(camera, kViewport.aspect(), at_m + step_m * camera.right());
        const double up_px = static_cast<double>(above.y - here.y) / 2.0 * kViewport.height_px;
        const double right_px = static_cast<double>(beside.x - here.x) / 2.0 * kViewport.width_px;
        const double pixel_m = camera.metres_per_pixel(at_m, kViewport.height_px);
        ASSERT_NEAR(step_m / up_px, pixel_m, kRelative * pixel_m);
        ASSERT_NEAR(step_m / right_px, pixel_m, kRelative * pixel_m); // pixels are square
    }
}

TEST(Camera, MetresPerPixelBehindTheEyeAreThoseInFrontOfIt) {
    RandomViews random(9);
    for (int i = 0; i < 100; ++i) {
        const Camera camera = random.camera();
        const double depth_m = random.between(0.1, 2.0) * camera.distance_m();
        const auto pixel_m = [&](double at_depth_m) {
            return camera.metres_per_pixel(camera.eye_m() + at_depth_m * camera.forward(),
                                           kViewport.height_px);
        };
        ASSERT_GT(pixel_m(depth_m), 0.0);
        ASSERT_NEAR(pixel_m(-depth_m), pixel_m(depth_m), 1e-9 * pixel_m(depth_m));
    }
}

TEST(Camera, ViewpointsLookFromWhereTheySay) {
    Camera camera;
    camera.look_from(Viewpoint::home);
    EXPECT_GT(camera.eye_m().z(), 0.2);
    EXPECT_GT(camera.eye_m().y(), 0.0);
    EXPECT_GT(camera.eye_m().x(), 0.0);
    EXPECT_LT(camera.eye_m().x(), camera.eye_m().z());
    camera.look_from(Viewpoint::top);
    EXPECT_LT((camera.forward() + Vector3::UnitY()).norm(), kExact);
    EXPECT_LT((camera.right() - Vector3::UnitX()).norm(), kExact);
    camera.look_from(Viewpoint::front);
    EXPECT_LT((camera.forward() + Vector3::UnitZ()).norm(), kExact);
    EXPECT_LT((camera.up() - Vector3::UnitY()).norm(), kExact);
}

TEST(Camera, OrbitKeepsDistanceAndTarget) {
    RandomViews random(9);
    Camera camera = random.camera();
    const Vector3 target_m = camera.target_m();
    const double distance_m = camera.distance_m();
    for (int i = 0; i < 1000; ++i) {
        camera.orbit(random.between(-300.0, 300.0), random.between(-300.0, 300.0));
        ASSERT_EQ(camera.target_m(), target_m);
        ASSERT_NEAR((camera.eye_m() - target_m).norm(), distance_m, kExact);
    }
}

TEST(Camera, OrbitDraggedRightShowsTheLeftSide) {
    Camera camera;
    camera.orbit(50.0, 0.0);
    EXPECT_LT(camera.eye_m().x(), 0.0);
    Camera other;
    other.orbit(0.0, 50.0); // dragged down: from above
    EXPECT_GT(other.eye_m().y(), 0.0);
}

TEST(Camera, PanCarriesTheTargetPlaneAlongWithTheMouse) {
    RandomViews random(10);
    for (int i = 0; i < 200; ++i) {
        Camera camera = random.camera();
        const PixelPoint start{random.between(0.0, 880.0), random.between(0.0, 520.0)};
        const Vector3 grabbed_m = camera.point_at(start, kViewport, camera.target_m());
        camera.pan(37.0, -21.0, kViewport.height_px);
        const std::optional<PixelPoint> end = camera.pixel_of(grabbed_m, kViewport);
        ASSERT_TRUE(end.has_value());
        ASSERT_NEAR(end->x_px, start.x_px + 37.0, 1e-8);
        ASSERT_NEAR(end->y_px, start.y_px - 21.0, 1e-8);
    }
}

const Vector3 kBoxCorner_m(0.1, 0.1, 0.1);

TEST(Camera, ZoomKeepsThePointThatItZoomsToAtItsPixel) {
    RandomViews random(11);
    int nearer = 0;
    for (int i = 0; i < 500; ++i) {
        Camera camera = random.camera();
        const Vector3 about_m = camera.target_m() + random.point(0.3 * camera.distance_m());
        const std::optional<PixelPoint> before = camera.pixel_of(about_m, kViewport);
        ASSERT_TRUE(before.has_value());
        const double depth_m = (about_m - camera.eye_m()).dot(camera.forward());
        const double distance_m = camera.distance_m();
        camera.zoom(random.between(-6.0, 6.0), about_m);
        const std::optional<PixelPoint> after = camera.pixel_of(about_m, kViewport);
        ASSERT_TRUE(after.has_value());
        // Hundreds of pixels, each with a rounding error of some 1e-16 of the distance.
        ASSERT_NEAR(after->x_px, before->x_px, 1e-8);
        ASSERT_NEAR(after->y_px, before->y_px, 1e-8);
        // The point is as much nearer as the target is.
        ASSERT_NEAR((about_m - camera.eye_m()).dot(camera.forward()) / depth_m,
                    camera.distance_m() / distance_m, 1e-9);
        nearer += camera.distance_m() < distance_m ? 1 : 0;
    }
    EXPECT_GT(nearer, 100); // both directions were tried
    EXPECT_LT(nearer, 400);
}

TEST(Camera, ZoomBackAndForthComesBack) {
    Camera camera = testing::framed_box(-kBoxCorner_m, kBoxCorner_m, kViewport);
    const Camera before = camera;
    const Vector3 about_m(0.05, 0.02, -0.03);
    camera.zoom(3.0, about_m);
    EXPECT_LT(camera.distance_m(), before.distance_m());
    camera.zoom(-3.0, about_m);
    EXPECT_NEAR(camera.distance_m(), before.distance_m(), kExact);
    EXPECT_LT((camera.eye_m() - before.eye_m()).norm(), kExact);
}

TEST(Camera, ZoomNeverPassesThroughThePoint) {
    Camera camera = testing::framed_box(-kBoxCorner_m, kBoxCorner_m, kViewport);
    camera.zoom(1e6, kBoxCorner_m);
    EXPECT_GT(camera.distance_m(), 0.0);
    EXPECT_GT((kBoxCorner_m - camera.eye_m()).dot(camera.forward()), 0.0);
    camera.zoom(-1e6, kBoxCorner_m);
    EXPECT_LT(camera.distance_m(), 100.0);
}

} // namespace
} // namespace springdrive::app
