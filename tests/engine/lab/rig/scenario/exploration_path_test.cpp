// Covers engine/lab/rig/scenario/exploration_path.cpp.
#include "tests/engine/lab/model_selection/model_settings.h"

#include <gtest/gtest.h>

#include <cmath>

namespace springdrive::rig {
namespace {

TEST(ExplorationPath, ComesByAllOverAndInReach) {
    const device::DeviceDescription device = testing::phantom_1_0();
    for (const std::string name :
         {"plate", "slope", "wrong_direction", "compliance", "stepped_block", "organic",
          "thin_plate", "sphere", "spheres", "blow"}) {
        const scene::Scene scene = testing::own_scene(name);
        const model_selection::ModelSetting setting =
            testing::exploring(contact::HapticSurface(scene.surface), testing::box_of(scene));
        Eigen::AlignedBox3d felt;
        for (const simulated::HandPath::Point &point : setting.scenario.simulation.path->points()) {
            EXPECT_TRUE(device::can_reach(device, point.position_m)) << name;
            felt.extend(point.position_m);
        }
        const Vector3 size_m = testing::box_of(scene).sizes();
        EXPECT_GT(felt.sizes().x(), 0.3 * size_m.x()) << name;
        EXPECT_GT(felt.sizes().z(), 0.3 * size_m.z()) << name;
        EXPECT_LE(felt.sizes().x(), 0.7 * size_m.x() + 1e-9) << name;
    }
}

TEST(ExplorationPath, LetsGoAndPressesInAgain) {
    const scene::Scene scene = testing::own_scene("plate");
    const model_selection::ModelSetting setting =
        testing::exploring(contact::HapticSurface(scene.surface), testing::box_of(scene));
    const Exploration how;
    double deepest_m = 0.0;
    double max_m = -1.0;
    for (const simulated::HandPath::Point &point : setting.scenario.simulation.path->points()) {
        if (point.time_s > how.rest_s + how.approach_s) {
            const double depth_m = scene.upper_m.y() - point.position_m.y();
            deepest_m = std::max(deepest_m, depth_m);
            max_m = std::max(max_m, -depth_m);
        }
    }
    // The path's points, 5 ms apart, miss the turning points of 3 Hz by (ωΔt/2)²/2 = 0.1 % at most.
    EXPECT_NEAR(deepest_m, how.max_depth_m, 1e-5);
    EXPECT_NEAR(max_m, -how.min_depth_m, 1e-5);
}

TEST(ExplorationPath, NeitherJumpsNorLeavesItsPlane) {
    const scene::Scene scene = testing::own_scene("profile");
    Exploration how;
    how.planar = true;
    const model_selection::ModelSetting setting =
        testing::exploring(contact::HapticSurface(scene.surface), testing::box_of(scene), how);
    const auto &points = setting.scenario.simulation.path->points();
    const double pressing_m_per_s =
        2.0 * M_PI * how.press_hz * 0.5 * (how.max_depth_m - how.min_depth_m);
    for (std::size_t i = 1; i < points.size(); ++i) {
        EXPECT_EQ(points[i].position_m.x(), points.front().position_m.x());
        if (points[i - 1].time_s > how.rest_s + how.approach_s - 1e-9) {
            const double dt_s = points[i].time_s - points[i - 1].time_s;
            EXPECT_LE(std::abs(points[i].position_m.y() - points[i - 1].position_m.y()),
                      1.001 * dt_s * (how.climb_m_per_s + pressing_m_per_s));
        }
    }
}

TEST(ExplorationPath, StaysWhereItCannotReachAnything) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const contact::TriangleSoup far = icosphere(2, 0.02);
    contact::TriangleSoup away = far;
    for (Vector3 &vertex_m : away.vertices_m) {
        vertex_m.y() += 2.0;
    }
    const simulated::HandPath path = exploration_path(
        device, contact::HapticSurface(away), testing::box_of(away), device.workspace.centre_m);
    for (const simulated::HandPath::Point &point : path.points()) {
        EXPECT_EQ(point.position_m, device.workspace.centre_m);
    }
}

} // namespace
} // namespace springdrive::rig
