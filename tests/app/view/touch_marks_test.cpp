// Covers app/view/touch_marks.cpp: the marks that tell where the tip is in depth.
#include "app/view/touch_marks.h"

#include "app/view/gl_vector.h"
#include "tests/support/framed_box.h"

#include <gtest/gtest.h>

#include <cmath>

namespace springdrive::app {
namespace {

constexpr double kMarked_m = 1e-6; // of coordinates below a metre in float
constexpr PixelSize kMarkedViewport{880.0, 485.0};

Camera marked_camera() {
    return testing::framed_box(Vector3::Constant(-0.1), Vector3::Constant(0.1), kMarkedViewport);
}

/// The point of the world at that place of the unit shape.
Vector3 marked_point(const Solid &solid, float x, float y, float z) {
    return to_vector3(glm::vec3(solid.model * glm::vec4(x, y, z, 1.0F)));
}

TEST(HeightLine, LeadsFromTipOrProxyToARingThatLiesOnWhatIsBelow) {
    const Camera camera = marked_camera();
    const MarkerScale scale{camera, kMarkedViewport.height_px, 1.0};
    ViewState state;
    state.tip_m = {0.02, 0.05, -0.01};
    state.proxy_m = {0.021, 0.055, -0.012};
    const Vector3 normal = Vector3(0.3, 0.9, 0.1).normalized();
    for (const bool touching : {false, true}) {
        state.touching = touching;
        const Vector3 top_m = touching ? state.proxy_m : state.tip_m;
        state.below = {{top_m.x(), -0.03, top_m.z()}, normal};
        const std::vector<Solid> solids = height_line(state, scale);
        ASSERT_EQ(solids.size(), 2U);
        EXPECT_EQ(solids[0].shape, Shape::cylinder);
        EXPECT_LT((marked_point(solids[0], 0, 0, 0) - top_m).norm(), kMarked_m);
        EXPECT_LT((marked_point(solids[0], 0, 0, 1) - state.below->point_m).norm(), kMarked_m);
        EXPECT_EQ(solids[1].shape, Shape::ring);
        const Vector3 centre_m = marked_point(solids[1], 0, 0, 0);
        EXPECT_NEAR((centre_m - state.below->point_m).norm(), 4e-4, kMarked_m); // so as to be seen
        for (const auto &[x, y] : {std::pair{1.0F, 0.0F}, {0.0F, 1.0F}, {-0.6F, 0.8F}}) {
            const Vector3 radius_m = marked_point(solids[1], x, y, 0) - centre_m;
            EXPECT_NEAR(radius_m.dot(normal), 0.0, kMarked_m);
            EXPECT_GT(radius_m.norm(), 3e-3);
        }
    }
}

TEST(HeightLine, IsNotThereWhereNothingIsBelowOrTheTipIsThere) {
    const Camera camera = marked_camera();
    const MarkerScale scale{camera, kMarkedViewport.height_px, 1.0};
    ViewState state;
    EXPECT_TRUE(height_line(state, scale).empty());
    for (const auto &[height_m, is_shown] : {std::pair{0.9e-3, false}, {1.1e-3, true}}) {
        state.below = {state.tip_m - Vector3(0.0, height_m, 0.0), Vector3::UnitY()};
        EXPECT_EQ(!height_line(state, scale).empty(), is_shown) << height_m;
    }
}

TEST(TipGhost, IsWiderThanTheTipFromNearAndFar) {
    Camera camera = marked_camera();
    for (const double steps : {0.0, -20.0, 35.0}) {
        camera.zoom(steps, camera.target_m());
        const MarkerScale scale{camera, kMarkedViewport.height_px, 1.0};
        const ViewState state;
        const TipMarks marks = tip_marks(state, scale);
        ASSERT_EQ(marks.tip.size(), 1U);
        ASSERT_EQ(marks.ghost.size(), 1U);
        const Solid &tip = marks.tip.front();
        const Solid &ghost = marks.ghost.front();
        const auto radius_m = [](const Solid &solid) {
            return (marked_point(solid, 1, 0, 0) - marked_point(solid, 0, 0, 0)).norm();
        };
        EXPECT_GT((1.0 - 0.5 * kRingThickness) * radius_m(ghost), 1.4 * radius_m(tip));
        // It faces the camera.
        EXPECT_NEAR((marked_point(ghost, 0, 0, 1) - marked_point(ghost, 0, 0, 0))
                        .normalized()
                        .dot(camera.forward()),
                    1.0, 1e-5); // float
    }
}

} // namespace
} // namespace springdrive::app
