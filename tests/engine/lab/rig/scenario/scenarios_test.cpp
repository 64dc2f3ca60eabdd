// Covers engine/lab/rig/scenario/{scenarios,exploration_path}.cpp.
#include "engine/lab/rig/scenario/scenarios.h"

#include "engine/lab/rig/law_rig.h"
#include "engine/lab/rig/servo_rig.h"
#include "tests/engine/lab/model_selection/model_settings.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

namespace springdrive::rig {
namespace {

/// Long enough for the servo to start up and for the hand to touch.
constexpr double kMax_s = 2.5;

double run_s(const Scenario &scenario) { return std::min(scenario.duration_s, kMax_s); }

TEST(Scenarios, KeepTheHandWithinReach) {
    for (const device::DeviceDescription &device :
         {testing::phantom_1_0(), testing::phantom_premium_1_5()}) {
        for (const ListedScenario &listed : kScenarios) {
            const Scenario made = listed.make({device, {}});
            EXPECT_TRUE(device::can_reach(device, made.start_m)) << listed.name;
            EXPECT_GT(made.duration_s, 0.0) << listed.name;
            if (made.simulation.path) {
                for (const simulated::HandPath::Point &point : made.simulation.path->points()) {
                    ASSERT_TRUE(device::can_reach(device, point.position_m)) << listed.name;
                }
            }
        }
    }
}

TEST(Scenarios, StartFreeOrAtTheirContact) {
    for (const ListedScenario &listed : kScenarios) {
        const Scenario made = listed.make({testing::phantom_1_0(), {}});
        const contact::Contact contact = made.constraint(made.start_m);
        if (made.surface) {
            EXPECT_FALSE(contact.touching) << listed.name;
        } else if (contact.touching) { // on a plane of two sides, or beside a point
            EXPECT_LE((contact.x0_m - made.start_m).norm(), 1e-3 * (1.0 + 1e-12)) << listed.name;
        }
    }
}

TEST(Scenarios, KeepWhatTheyAreGiven) {
    for (const ListedScenario &listed : kScenarios) {
        ScenarioSetting setting{testing::phantom_1_0(), {}};
        setting.tuning.K_P_V_per_rad = 2.5;
        setting.period_s = 0.5e-3;
        setting.delay_periods = 1.25;
        const Scenario made = listed.make(setting);
        EXPECT_EQ(made.tuning.K_P_V_per_rad, 2.5) << listed.name;
        EXPECT_EQ(made.simulation.servo_period_s, 0.5e-3) << listed.name;
        EXPECT_EQ(made.simulation.delay_periods, 1.25) << listed.name;
        EXPECT_EQ(made.device.name, setting.device.name) << listed.name;
    }
}

/// Of a servo, where there is a surface for its proxy, or in free space.
TEST(Scenarios, RunUnderAServoWithoutATrip) {
    for (const ListedScenario &listed : kScenarios) {
        const Scenario made = listed.make({testing::phantom_1_0(), {}});
        if (!made.surface) {
            continue;
        }
        ServoRig rig(made);
        int touching = 0;
        for (long i = std::lround(run_s(made) / made.simulation.servo_period_s); i > 0; --i) {
            touching += rig.tick().contact.touching ? 1 : 0;
            ASSERT_FALSE(rig.has_tripped())
                << listed.name << ": " << servo::description(rig.last.safety);
        }
        EXPECT_EQ(touching > 0, listed.name != "corner") << listed.name; // its user presses
    }
}

TEST(Scenarios, RunUnderALawAloneAndStayFinite) {
    for (const ListedScenario &listed : kScenarios) {
        const Scenario made = listed.make({testing::phantom_1_0(), {}});
        simulated::SimulatedPhantom phantom(made.device, made.simulation, made.start_m);
        PhantomPlant plant(phantom);
        LawOptions options;
        options.device = made.device;
        options.tuning = made.tuning;
        LawRig rig(plant, options, made.constraint, FirstCommand::brakes);
        for (long i = std::lround(run_s(made) / made.simulation.servo_period_s); i > 0; --i) {
            rig.tick();
        }
        // Not run away: a NaN fails, too.
        EXPECT_LT((phantom.truth().tip_m - made.start_m).norm(),
                  made.device.workspace.size_m.norm())
            << listed.name;
        EXPECT_TRUE(rig.command().spring_drive.e_W_V.allFinite()) << listed.name;
    }
}

/// docs/design.md has the same list.
TEST(Scenarios, AreInTheDesign) {
    const std::string design =
        testing::contents_of(testing::assets().parent_path() / "docs/design.md");
    std::set<std::string_view> names;
    for (const ListedScenario &listed : kScenarios) {
        EXPECT_TRUE(names.insert(listed.name).second) << listed.name;
        EXPECT_FALSE(listed.what.empty() || listed.measured.empty()) << listed.name;
        const std::string row = "| " + std::string(listed.name) + " | " + std::string(listed.what) +
                                " | " + std::string(listed.measured) + " |";
        EXPECT_NE(design.find(row), std::string::npos) << row;
    }
}

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
    contact::TriangleSoup away = icosphere(2, 0.02);
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
