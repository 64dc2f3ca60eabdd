// Covers app/view/framing.cpp: everything is in the picture, and no smaller than it must be.
#include "app/view/framing.h"

#include "app/demo/layout.h"
#include "app/view/gl_vector.h"
#include "app/view/linkage_solids.h"
#include "engine/scene/gltf.h"
#include "engine/scene/scripted_touch.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <vector>

namespace springdrive::app {
namespace {

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

TEST(Framing, PointsOfSolidsAreWhereTheyAreDrawn) {
    const std::vector<Solid> solids{
        spindle(Shape::cylinder, {0.0, 0.1, 0.0}, {0.0, 0.4, 0.0}, 0.02, kTipColour)};
    Vector3 lower_m = Vector3::Constant(1e9);
    Vector3 upper_m = Vector3::Constant(-1e9);
    for (const Vector3 &point_m : drawn_points(solids)) {
        lower_m = lower_m.cwiseMin(point_m);
        upper_m = upper_m.cwiseMax(point_m);
    }
    constexpr double kFramedFloat_m = 1e-6;
    EXPECT_LT((lower_m - Vector3(-0.02, 0.1, -0.02)).norm(), kFramedFloat_m);
    EXPECT_LT((upper_m - Vector3(0.02, 0.4, 0.02)).norm(), kFramedFloat_m);
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

} // namespace
} // namespace springdrive::app
