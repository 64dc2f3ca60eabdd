// Covers engine/lab/rig/scenario/{scenarios,exploration_path,touch_path}.cpp and
// engine/scene/scripted_touch.cpp.
#include "engine/lab/rig/law_rig.h"
#include "engine/lab/rig/scenario/scenarios.h"
#include "engine/lab/rig/scenario/touch_path.h"
#include "engine/lab/rig/servo_rig.h"
#include "engine/scene/scripted_touch.h"
#include "tests/engine/contact/mesh/soups.h"
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

constexpr double kRadius_m = 0.05;

/// By how much facets of the sphere below lie under it in the middle: e²/6R for an edge e of 7.5
/// mm.
constexpr double kSag_m = 0.3e-3;

const contact::HapticSurface &sphere() {
    static const contact::HapticSurface surface(testing::icosphere(3, kRadius_m));
    return surface;
}

const Eigen::AlignedBox3d kBox(Vector3::Constant(-kRadius_m), Vector3::Constant(kRadius_m));

std::vector<Vector3> path(TouchPathKind kind, std::size_t steps, std::uint64_t seed = 1) {
    TouchPathOptions options;
    options.kind = kind;
    options.steps = steps;
    options.seed = seed;
    return touch_path(sphere(), kBox, options);
}

TEST(TouchPath, HasAllItsStepsStartsFreeAndFollowsItsSeed) {
    EXPECT_EQ(touch_path_named("slid"), std::nullopt);
    EXPECT_EQ(touch_path_named(""), std::nullopt);
    for (const TouchPathName &known : kTouchPathNames) {
        EXPECT_EQ(touch_path_named(known.name), known.kind);
        for (const std::size_t steps : {std::size_t{1}, std::size_t{2}, std::size_t{3000}}) {
            const std::vector<Vector3> tips = path(known.kind, steps, 5);
            ASSERT_EQ(tips.size(), steps) << known.name;
            EXPECT_GT(tips.front().norm(), kRadius_m) << known.name;
            for (const Vector3 &tip : tips) {
                ASSERT_TRUE(tip.allFinite()) << known.name;
            }
            EXPECT_EQ(tips, path(known.kind, steps, 5)) << known.name;
            EXPECT_NE(tips, path(known.kind, steps, 6)) << known.name;
        }
    }
}

TEST(TouchPath, PressGoesAsDeepAsAskedAndComesOut) {
    const std::vector<Vector3> tips = path(TouchPathKind::press, 20000);
    int presses = 0;
    bool is_in = false;
    double deepest_m = 0.0;
    for (std::size_t i = 1; i < tips.size(); ++i) {
        const double depth_m = kRadius_m - tips[i].norm();
        deepest_m = std::max(deepest_m, depth_m);
        ASSERT_LT(depth_m, 1.5e-3 + kSag_m);
        if (depth_m > kSag_m) {
            presses += is_in ? 0 : 1;
            is_in = true;
            // Corners of the way may be cut, never stretched.
            ASSERT_LT((tips[i] - tips[i - 1]).norm(), 1.0001e-4);
        } else if (depth_m < 0.0) {
            is_in = false;
        }
    }
    EXPECT_GT(deepest_m, 1.3e-3); // some go in squarely
    EXPECT_GT(presses, 100);
}

TEST(TouchPath, SlideStaysAtItsDepthAndSpeed) {
    const std::vector<Vector3> tips = path(TouchPathKind::slide, 20000);
    std::size_t entered = 0;
    while (tips[entered].norm() > kRadius_m - 1.5e-3) {
        ASSERT_LT(++entered, 100U); // 3.5 mm at 0.1 m/s, after two leaps
    }
    std::array<int, 8> octants{};
    int corners = 0;
    for (std::size_t i = entered + 1; i < tips.size(); ++i) {
        const double depth_m = kRadius_m - tips[i].norm();
        ASSERT_GT(depth_m, 1.5e-3 - 1e-6);
        ASSERT_LT(depth_m, 1.5e-3 + kSag_m);
        const double step_m = (tips[i] - tips[i - 1]).norm();
        ASSERT_LT(step_m, 1.0001e-4);
        corners += step_m < 0.95e-4 ? 1 : 0; // which are cut
        ++octants[(tips[i].x() > 0 ? 1U : 0U) + (tips[i].y() > 0 ? 2U : 0U) +
                  (tips[i].z() > 0 ? 4U : 0U)];
    }
    EXPECT_LE(corners, 7); // one a great circle, of which 2 m hold less than seven
    for (const int visits : octants) {
        EXPECT_GT(visits, 0);
    }
}

TEST(TouchPath, LissajousChangesItsDepthByAThird) {
    const std::vector<Vector3> tips = path(TouchPathKind::lissajous, 20000);
    double min_m = 1.0;
    double max_m = 0.0;
    for (std::size_t i = 100; i < tips.size(); ++i) {
        const double depth_m = kRadius_m - tips[i].norm();
        min_m = std::min(min_m, depth_m);
        max_m = std::max(max_m, depth_m);
        ASSERT_NEAR((tips[i] - tips[i - 1]).norm(), 1e-4, 2e-5);
    }
    EXPECT_GT(min_m, 1.0e-3 - 1e-5);
    EXPECT_LT(min_m, 1.1e-3 + kSag_m);
    EXPECT_GT(max_m, 1.9e-3);
    EXPECT_LT(max_m, 2.0e-3 + kSag_m);
}

TEST(TouchPath, RainFallsFreely) {
    const std::vector<Vector3> tips = path(TouchPathKind::rain, 20000);
    int falling = 0;
    int drops = 0;
    for (std::size_t i = 2; i < tips.size(); ++i) {
        const bool is_one_drop = tips[i].x() == tips[i - 2].x() && tips[i].z() == tips[i - 2].z();
        drops += tips[i].x() != tips[i - 1].x() ? 1 : 0;
        const double bend_m = tips[i].y() - 2.0 * tips[i - 1].y() + tips[i - 2].y();
        falling += is_one_drop && std::abs(bend_m + 9.81e-6) < 1e-15 ? 1 : 0;
    }
    EXPECT_GT(drops, 20);
    EXPECT_GT(falling, 15000); // all but where it rests, turns or leaps
}

TEST(TouchPath, RandomWandersInABoxAFifthLarger) {
    const std::vector<Vector3> tips = path(TouchPathKind::random, 50000);
    int leaps = 0;
    std::size_t entered = 0;
    const Eigen::AlignedBox3d room(1.2 * kBox.min(), 1.2 * kBox.max());
    while (!room.contains(tips[entered])) {
        ASSERT_LT(++entered, 1000U);
    }
    for (std::size_t i = entered + 1; i < tips.size(); ++i) {
        const double step_m = (tips[i] - tips[i - 1]).norm();
        leaps += step_m > 1.0001e-4 ? 1 : 0;
        ASSERT_LT(room.exteriorDistance(tips[i]), 1e-3); // turns within a few ticks
    }
    EXPECT_GT(leaps, 20); // one in a thousand
    EXPECT_LT(leaps, 100);
}

TEST(TouchPath, StaysOutsideWhereNothingIs) {
    const contact::HapticSurface nothing;
    TouchPathOptions options;
    options.steps = 5000;
    for (const TouchPathKind kind :
         {TouchPathKind::press, TouchPathKind::slide, TouchPathKind::lissajous}) {
        options.kind = kind;
        for (const Vector3 &tip : touch_path(nothing, kBox, options)) {
            ASSERT_FALSE(kBox.contains(tip));
        }
    }
}

TEST(TouchPath, KeepsTheProxysRadiusInMind) {
    TouchPathOptions options;
    options.steps = 501;
    options.radius_m = 5e-3;
    EXPECT_NEAR(touch_path(sphere(), kBox, options).back().norm(), kRadius_m + 5e-3 - 1.5e-3,
                kSag_m);
}

TEST(SurfaceProbe, FindsWhatIsFirstOnTheWay) {
    const scene::SurfaceProbe probe(sphere(), kBox, 0.0);
    std::mt19937_64 random(3);
    for (int i = 0; i < 300; ++i) {
        const Vector3 direction = testing::random_direction(random);
        const std::optional<Vector3> touch = probe.touch_from(direction);
        ASSERT_TRUE(touch.has_value());
        EXPECT_LT((touch->normalized() - direction).norm(), 1e-12);
        EXPECT_LT(touch->norm(), kRadius_m + 2e-8); // the clearance of 10 nm, at a slant
        EXPECT_GT(touch->norm(), kRadius_m - kSag_m);
        EXPECT_FALSE(probe.first_touch(2.0 * kRadius_m * direction, 1.01 * kRadius_m * direction));
    }
}

} // namespace
} // namespace springdrive::rig
