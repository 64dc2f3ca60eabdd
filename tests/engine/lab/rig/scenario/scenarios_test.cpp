// Covers engine/lab/rig/scenario/scenarios.cpp.
#include "engine/lab/rig/scenario/scenarios.h"

#include "engine/lab/rig/law_rig.h"
#include "engine/lab/rig/servo_rig.h"
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

TEST(Scenarios, HaveNamesOfTheirOwnAndSayWhatTheyAreFor) {
    std::set<std::string_view> names;
    for (const ListedScenario &listed : kScenarios) {
        EXPECT_TRUE(names.insert(listed.name).second) << listed.name;
        EXPECT_FALSE(listed.what.empty() || listed.measured.empty()) << listed.name;
    }
}

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
    for (const ListedScenario &listed : kScenarios) {
        const std::string row = "| " + std::string(listed.name) + " | " + std::string(listed.what) +
                                " | " + std::string(listed.measured) + " |";
        EXPECT_NE(design.find(row), std::string::npos) << row;
    }
}

} // namespace
} // namespace springdrive::rig
