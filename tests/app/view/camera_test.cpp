// Covers app/view/camera.cpp, and the light's matrix of app/view/shadows.cpp: where points are
// seen, what a user's actions do, and that everything is in the picture, and no smaller than it
// must be.
#include "app/view/camera.h"

#include "app/demo/layout.h"
#include "app/view/shadows.h"
#include "app/view/solids.h"
#include "engine/scene/gltf.h"
#include "engine/scene/scripted_touch.h"
#include "tests/support/devices.h"
#include "tests/support/framed_box.h"

#include <Eigen/Geometry>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>
#include <vector>

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

TEST(Camera, PixelsAndPointsAreEachOthersAndWhereOpenGLDrawsThem) {
    RandomViews random(1);
    int seen = 0;
    for (int i = 0; i < 500; ++i) {
        const Camera camera = random.camera();
        // Axes are unit and right-handed, and the camera never rolls.
        ASSERT_NEAR(camera.right().norm(), 1.0, kExact);
        ASSERT_NEAR(camera.up().norm(), 1.0, kExact);
        ASSERT_LT((camera.right().cross(camera.up()) + camera.forward()).norm(), kExact);
        ASSERT_NEAR(camera.right().y(), 0.0, kExact);
        ASSERT_GT(camera.up().y(), 0.0);
        // A point is seen where OpenGL draws it, and comes back through its pixel.
        const Vector3 point_m = camera.target_m() + random.point(0.2 * camera.distance_m());
        const std::optional<PixelPoint> pixel = camera.pixel_of(point_m, kViewport);
        ASSERT_TRUE(pixel.has_value());
        const glm::vec3 drawn = device_coordinates(camera, kViewport.aspect(), point_m);
        ASSERT_NEAR(pixel->x_px, (1.0 + static_cast<double>(drawn.x)) / 2.0 * kViewport.width_px,
                    kFloatPixel_px);
        ASSERT_NEAR(pixel->y_px, (1.0 - static_cast<double>(drawn.y)) / 2.0 * kViewport.height_px,
                    kFloatPixel_px);
        seen += std::abs(drawn.x) < 1.0F && std::abs(drawn.y) < 1.0F ? 1 : 0;
        ASSERT_LT((camera.point_at(*pixel, kViewport, point_m) - point_m).norm(), kExact);
        // Any pixel's point is in the view plane through another one.
        const PixelPoint other{random.between(0.0, kViewport.width_px),
                               random.between(0.0, kViewport.height_px)};
        const Vector3 under_m = camera.point_at(other, kViewport, point_m);
        ASSERT_NEAR((under_m - point_m).dot(camera.forward()), 0.0, kExact);
        const std::optional<PixelPoint> back = camera.pixel_of(under_m, kViewport);
        ASSERT_TRUE(back.has_value());
        // Hundreds of pixels, each with a rounding error of some 1e-16 of the distance.
        ASSERT_NEAR(back->x_px, other.x_px, 1e-8);
        ASSERT_NEAR(back->y_px, other.y_px, 1e-8);
        // Behind the eye is none.
        ASSERT_FALSE(camera.pixel_of(camera.eye_m(), kViewport).has_value());
        ASSERT_FALSE(
            camera.pixel_of(camera.eye_m() - 0.1 * camera.forward(), kViewport).has_value());
    }
    EXPECT_GT(seen, 400); // not vacuous: most are on the screen
}

TEST(Camera, MetresPerPixelIsTheProjectionsSlopeAndTheSameBehindTheEye) {
    RandomViews random(7);
    // A step of 0.1 of the depth: float round-off in the quotient stays below 1e-5, and within a
    // view plane the projection is linear, so that there is no truncation.
    constexpr double kRelative = 1e-4;
    for (int i = 0; i < 500; ++i) {
        const Camera camera = random.camera();
        const Vector3 at_m = camera.target_m() + random.point(0.2 * camera.distance_m());
        const double step_m = 0.1 * camera.distance_m();
        const auto seen = [&](const Vector3 &step) {
            return device_coordinates(camera, kViewport.aspect(), at_m + step);
        };
        const glm::vec3 here = seen(Vector3::Zero());
        const auto up = static_cast<double>(seen(step_m * camera.up()).y - here.y);
        const auto right = static_cast<double>(seen(step_m * camera.right()).x - here.x);
        const double pixel_m = camera.metres_per_pixel(at_m, kViewport.height_px);
        ASSERT_NEAR(step_m / (up / 2.0 * kViewport.height_px), pixel_m, kRelative * pixel_m);
        ASSERT_NEAR(step_m / (right / 2.0 * kViewport.width_px), pixel_m,
                    kRelative * pixel_m); // pixels are square
        ASSERT_GT(pixel_m, 0.0);
        ASSERT_NEAR(camera.metres_per_pixel(2.0 * camera.eye_m() - at_m, kViewport.height_px),
                    pixel_m, 1e-9 * pixel_m);
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

TEST(Camera, OrbitKeepsDistanceAndTargetAndShowsTheSideDraggedFrom) {
    RandomViews random(9);
    Camera camera = random.camera();
    const Vector3 target_m = camera.target_m();
    const double distance_m = camera.distance_m();
    for (int i = 0; i < 1000; ++i) {
        camera.orbit(random.between(-300.0, 300.0), random.between(-300.0, 300.0));
        ASSERT_EQ(camera.target_m(), target_m);
        ASSERT_NEAR((camera.eye_m() - target_m).norm(), distance_m, kExact);
    }
    Camera right;
    right.orbit(50.0, 0.0);
    EXPECT_LT(right.eye_m().x(), 0.0);
    Camera down;
    down.orbit(0.0, 50.0);
    EXPECT_GT(down.eye_m().y(), 0.0);
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

TEST(Camera, ZoomComesBackAndNeverPassesThroughThePoint) {
    const Vector3 corner_m(0.1, 0.1, 0.1);
    Camera camera = testing::framed_box(-corner_m, corner_m, kViewport);
    const Camera before = camera;
    const Vector3 about_m(0.05, 0.02, -0.03);
    camera.zoom(3.0, about_m);
    EXPECT_LT(camera.distance_m(), before.distance_m());
    camera.zoom(-3.0, about_m);
    EXPECT_NEAR(camera.distance_m(), before.distance_m(), kExact);
    EXPECT_LT((camera.eye_m() - before.eye_m()).norm(), kExact);
    camera.zoom(1e6, corner_m);
    EXPECT_GT(camera.distance_m(), 0.0);
    EXPECT_GT((corner_m - camera.eye_m()).dot(camera.forward()), 0.0);
    camera.zoom(-1e6, corner_m);
    EXPECT_LT(camera.distance_m(), 100.0);
}

// Pixels in the thousands, computed in double from coordinates of some metres.
constexpr double kRounding_px = 1e-6;

constexpr PixelSize kFramedViewport{880.0, 485.0};

bool contains(const PixelRectangle &outer, const PixelRectangle &inner) {
    return inner.top_left.x_px > outer.top_left.x_px - kRounding_px &&
           inner.top_left.y_px > outer.top_left.y_px - kRounding_px &&
           inner.bottom_right.x_px < outer.bottom_right.x_px + kRounding_px &&
           inner.bottom_right.y_px < outer.bottom_right.y_px + kRounding_px;
}

/// Whether both borders of one direction are touched, so that the eye cannot be nearer.
bool fills(const PixelRectangle &outer, const PixelRectangle &inner) {
    const auto touches = [](double a, double b) { return std::abs(a - b) < kRounding_px; };
    return (touches(inner.top_left.x_px, outer.top_left.x_px) &&
            touches(inner.bottom_right.x_px, outer.bottom_right.x_px)) ||
           (touches(inner.top_left.y_px, outer.top_left.y_px) &&
            touches(inner.bottom_right.y_px, outer.bottom_right.y_px));
}

Camera at(Viewpoint viewpoint) {
    Camera camera;
    camera.look_from(viewpoint);
    return camera;
}

/// From the front, the corners of a square of half size a at z = 0 are seen at f a/d from the
/// middle, f = half the viewport's height by half_height_per_depth, d the distance: with all of the
/// viewport to fill, and more wide than high, d = a/half_height_per_depth.
TEST(Framing, OfASquareFromTheFrontIsTheClosedForm) {
    constexpr double kHalf_m = 0.1;
    const std::vector<Vector3> square_m{{-kHalf_m, -kHalf_m, 0.0},
                                        {kHalf_m, -kHalf_m, 0.0},
                                        {-kHalf_m, kHalf_m, 0.0},
                                        {kHalf_m, kHalf_m, 0.0}};
    const double distance_m = kHalf_m / Camera::half_height_per_depth();
    const Camera whole =
        framed(at(Viewpoint::front), square_m, kFramedViewport,
               {{0.0, 0.0}, {kFramedViewport.width_px, kFramedViewport.height_px}});
    EXPECT_LT((whole.eye_m() - Vector3(0.0, 0.0, distance_m)).norm(), 1e-12);

    // In the lower half alone: twice as far, and the eye is half the picture's height above.
    const Camera lower = framed(at(Viewpoint::front), square_m, kFramedViewport,
                                {{0.0, kFramedViewport.height_px / 2.0},
                                 {kFramedViewport.width_px, kFramedViewport.height_px}});
    EXPECT_LT((lower.eye_m() - Vector3(0.0, kHalf_m, 2.0 * distance_m)).norm(), 1e-12);

    // In a narrow part at the right edge: as wide as the part, which is a tenth of the viewport.
    const double right_m = 0.45 * 10.0 * 2.0 * kHalf_m; // from the middle to the part's middle
    const Camera beside = framed(at(Viewpoint::front), square_m, kFramedViewport,
                                 {{0.9 * kFramedViewport.width_px, 0.0},
                                  {kFramedViewport.width_px, kFramedViewport.height_px}});
    EXPECT_LT(
        (beside.eye_m() - Vector3(-right_m, 0.0, 10.0 * distance_m / kFramedViewport.aspect()))
            .norm(),
        1e-12);
}

TEST(Framing, OfAnyPointsInAnyPartContainsAllAndTouchesBothBordersOrTheNearestPoint) {
    std::mt19937_64 random(1);
    const auto between = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
    };
    int filled = 0;
    int stopped_before = 0;
    for (int i = 0; i < 2000; ++i) {
        Camera camera = at(Viewpoint::home);
        camera.orbit(between(-900.0, 900.0), between(-200.0, 200.0));
        const Vector3 centre_m(between(-2.0, 2.0), between(-2.0, 2.0), between(-2.0, 2.0));
        // From flat plates to long bars, millimetres to metres.
        const Vector3 extent_m(std::exp(between(-7.0, 1.0)), std::exp(between(-7.0, 1.0)),
                               std::exp(between(-7.0, 1.0)));
        std::vector<Vector3> points_m;
        for (int point = 0; point < 30; ++point) {
            points_m.push_back(centre_m +
                               extent_m.cwiseProduct(Vector3(between(-1.0, 1.0), between(-1.0, 1.0),
                                                             between(-1.0, 1.0))));
        }
        const PixelSize viewport{between(200.0, 2600.0), between(100.0, 1500.0)};
        const PixelRectangle part{
            {between(0.0, 0.4) * viewport.width_px, between(0.0, 0.4) * viewport.height_px},
            {between(0.5, 1.0) * viewport.width_px, between(0.5, 1.0) * viewport.height_px}};
        const Camera result = framed(camera, points_m, viewport, part);
        ASSERT_EQ(result.forward(), camera.forward()); // not turned
        const PixelRectangle drawn = drawn_part(result, points_m, viewport);
        ASSERT_TRUE(contains(part, drawn));
        double nearest_m = 1e9;
        double farthest_m = -1e9;
        for (const Vector3 &point_m : points_m) {
            const double depth_m = (point_m - result.eye_m()).dot(result.forward());
            nearest_m = std::min(nearest_m, depth_m);
            farthest_m = std::max(farthest_m, depth_m);
            // Neither cut off by the near plane nor by the far one.
            const glm::vec4 clip = result.projection(viewport.aspect()) * result.view() *
                                   glm::vec4(to_glm(point_m), 1.0F);
            ASSERT_LT(std::abs(clip.z), clip.w);
        }
        if (fills(part, drawn)) {
            ++filled;
        } else {
            ++stopped_before;
            const double before_m = std::max(0.1 * (farthest_m - nearest_m), 1e-3);
            ASSERT_NEAR(nearest_m, before_m, 1e-9);
        }
    }
    EXPECT_GT(filled, 1000); // not vacuous
    EXPECT_GT(stopped_before, 0);
}

TEST(Framing, OfOnePointLooksAtItInTheMiddleOfThePart) {
    const std::vector<Vector3> point_m{{0.1, 0.2, 0.3}};
    const PixelRectangle part{{100.0, 50.0}, {300.0, 250.0}};
    const Camera camera = framed(at(Viewpoint::home), point_m, kFramedViewport, part);
    const std::optional<PixelPoint> pixel = camera.pixel_of(point_m[0], kFramedViewport);
    ASSERT_TRUE(pixel.has_value());
    EXPECT_NEAR(pixel->x_px, 200.0, kRounding_px);
    EXPECT_NEAR(pixel->y_px, 150.0, kRounding_px);
    EXPECT_GT(camera.distance_m(), 0.0);
}

std::vector<std::filesystem::path> all_scenes() {
    std::vector<std::filesystem::path> files;
    for (const char *folder : {SPRINGDRIVE_ASSET_DIR "/scenes", SPRINGDRIVE_MODELS_DIR}) {
        for (const auto &entry : std::filesystem::directory_iterator(folder)) {
            if (entry.path().extension() == ".gltf" || entry.path().extension() == ".glb") {
                files.push_back(entry.path());
            }
        }
    }
    return files;
}

struct WindowOfSize {
    ImVec2 size;
    float scale;
};

/// Every vertex that is drawn, in every scene and at every size, from every viewpoint.
TEST(Framing, ShowsDeviceAndSceneWholeInEveryWindow) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const std::vector<std::filesystem::path> files = all_scenes();
    ASSERT_GT(files.size(), 5U);
    for (const std::filesystem::path &file : files) {
        const scene::Scene scene = scene::load_gltf(file, device.workspace);
        const Vector3 start_m = scene::start_above(device, scene.lower_m, scene.upper_m);
        const auto q_rad = device::joint_angles_rad(device.geometry, start_m);
        ASSERT_TRUE(q_rad.has_value());
        const double floor_m = device.workspace.centre_m.y() - device.workspace.size_m.y() / 2.0;
        std::vector<Vector3> framed_m = drawn_points(
            linkage_solids(device::linkage_pose(device.geometry, *q_rad), floor_m, false));
        std::vector<Vector3> drawn_m = framed_m;
        const auto corners = box_corners(scene.lower_m, scene.upper_m);
        framed_m.insert(framed_m.end(), corners.begin(), corners.end());
        for (const scene::VisualMesh &mesh : scene.meshes) {
            for (const scene::VisualVertex &vertex : mesh.vertices) {
                drawn_m.emplace_back(vertex.position_m[0], vertex.position_m[1],
                                     vertex.position_m[2]);
            }
        }
        for (const auto &[size, scale] :
             {WindowOfSize{{640.0F, 400.0F}, 0.625F}, WindowOfSize{{1280.0F, 720.0F}, 1.0F},
              WindowOfSize{{2560.0F, 1440.0F}, 2.0F}}) {
            const Rectangle view = layout(size, scale, 235.0F * scale).scene_view;
            const PixelSize viewport{view.size.x, view.size.y};
            const double margin_px = 0.1 * viewport.height_px;
            const PixelRectangle part{
                {margin_px, margin_px},
                {viewport.width_px - margin_px, viewport.height_px - margin_px}};
            for (const Viewpoint viewpoint : {Viewpoint::home, Viewpoint::top, Viewpoint::front}) {
                const Camera camera = framed(at(viewpoint), framed_m, viewport, part);
                // The scene's box is of float coordinates.
                const PixelRectangle drawn = drawn_part(camera, drawn_m, viewport);
                EXPECT_GT(drawn.top_left.x_px, part.top_left.x_px - 1e-2) << file;
                EXPECT_GT(drawn.top_left.y_px, part.top_left.y_px - 1e-2) << file;
                EXPECT_LT(drawn.bottom_right.x_px, part.bottom_right.x_px + 1e-2) << file;
                EXPECT_LT(drawn.bottom_right.y_px, part.bottom_right.y_px + 1e-2) << file;
                EXPECT_TRUE(fills(part, drawn_part(camera, framed_m, viewport))) << file;
            }
        }
    }
}

constexpr float kMapRounding = 1e-4F; // the key light is unit to four digits

glm::vec3 seen(const glm::mat4 &light, const glm::vec3 &point_m) {
    return glm::vec3(light * glm::vec4(point_m, 1.0F));
}

TEST(LightMatrix, TakesItsBallToTheMapAndKeepsDepthsAlongTheLight) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<float> coordinate(-1.0F, 1.0F);
    const glm::vec3 centre_m(0.1F, -0.2F, 0.05F);
    constexpr float kRadius_m = 0.4F;
    for (const glm::vec3 &towards : {kTowardsKeyLight, glm::vec3(0.0F, 1.0F, 0.0F)}) {
        const glm::mat4 light = light_matrix(towards, centre_m, kRadius_m);
        EXPECT_LT(glm::length(seen(light, centre_m) - glm::vec3(0.5F)), kMapRounding);
        for (int i = 0; i < 200; ++i) {
            const glm::vec3 offset_m =
                kRadius_m * glm::normalize(glm::vec3(coordinate(random), coordinate(random),
                                                     coordinate(random)));
            const glm::vec3 at = seen(light, centre_m + offset_m);
            for (int axis = 0; axis < 3; ++axis) {
                ASSERT_GT(at[axis], -kMapRounding);
                ASSERT_LT(at[axis], 1.0F + kMapRounding);
            }
            // Depth 0 is nearest to the light, one diameter before 1.
            ASSERT_NEAR(at.z, 0.5F - glm::dot(offset_m, towards) / (2.0F * kRadius_m),
                        kMapRounding);
            // What is farther along the light is at the same place of the map, and behind.
            const glm::vec3 behind = seen(light, centre_m + offset_m - 0.1F * towards);
            ASSERT_LT(glm::length(glm::vec2(behind) - glm::vec2(at)), kMapRounding);
            ASSERT_NEAR(behind.z - at.z, 0.1F / (2.0F * kRadius_m), kMapRounding);
        }
    }
}

TEST(LightMatrix, KeyLightIsUnitAndFromTheUpperLeftOfTheUser) {
    EXPECT_NEAR(glm::length(kTowardsKeyLight), 1.0F, kMapRounding);
    EXPECT_LT(kTowardsKeyLight.x, 0.0F);
    EXPECT_GT(kTowardsKeyLight.y, 0.5F);
    EXPECT_GT(kTowardsKeyLight.z, 0.0F);
}

} // namespace
} // namespace springdrive::app
