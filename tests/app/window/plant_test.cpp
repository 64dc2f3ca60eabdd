// Covers changes of the simulated device in the window: app/panels/plant_tab.cpp, and the hand's
// paths: app/panels/hand_tab.cpp.
#include "tests/support/devices.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <fstream>

namespace springdrive::app {
namespace {

using testing::Report;
using testing::ShownWindow;

TEST(PlantInTheWindow, RateDelayAndEffectsChangeWhileItRuns) {
    ShownWindow window;
    window.wait_until_running();
    window.click("Scene/Plant");
    window.enter("Plant/rate", "2000");
    window.wait_until(
        [](const Report &report) {
            const double period_s = report.column("since_last_s");
            return period_s == 5e-4;
        },
        "twice as fast");
    window.enter("Plant/rate", "3");
    EXPECT_TRUE(window.look().shows("3")) << window.look().texts();
    EXPECT_EQ(window.look().column("since_last_s"), 5e-4);
    const testing::Point delay = window.point_in("Plant/delay");
    window.person().press_key("Control_L");
    window.person().click(delay.x, delay.y);
    window.person().release_key("Control_L");
    window.person().type("1.5");
    window.person().key("Return");
    EXPECT_EQ(window.look().item("Plant/delay").at("value"), 1.5);
    window.click("Plant/gravity");
    EXPECT_EQ(window.look().item("Plant/gravity").at("value"), false);
    EXPECT_EQ(window.look().item("Plant/motor tolerances").at("enabled"), false);
    EXPECT_EQ(window.look().column("trip_cause"), 0.0);
}

TEST(PlantInTheWindow, AnotherDeviceIsChosenAndNamed) {
    ShownWindow window;
    EXPECT_TRUE(window.look().shows("PHANTOM 1.0, simulated"));
    window.click("Scene/Plant");
    window.choose("Plant/device", "simulated phantom_premium_1_5");
    window.wait_until(
        [](const Report &report) { return report.shows("PHANTOM Premium 1.5, simulated"); },
        "the other device is used");
}

TEST(PlantInTheWindow, TheHandFollowsAScriptOrAFile) {
    const std::filesystem::path folder = testing::fresh_folder("window_paths");
    ShownWindow window({"--scene", testing::assets() / "scenes/plate.gltf"}, {}, folder);
    window.wait_until_running();
    window.click("Scene/Hand");
    window.choose("Hand/grip", "firm hand");
    window.click("Hand/scripted touch");
    window.wait_until([](const Report &report) { return report.column("touching") == 1.0; },
                      "it touches");
    window.click("Hand/stop the path");
    window.wait_until(
        [](const Report &report) { return report.find("Hand/scripted touch") != nullptr; },
        "it has stopped");
    std::ofstream(folder / "up.csv") << "t,x,y,z\n0,0,0.05,0\n1,0.02,0.05,0\n";
    window.enter("Hand/path", "up.csv");
    window.wait_until(
        [](const Report &report) {
            return report.find("Hand/path") != nullptr &&
                   std::abs(report.column("tip_x_m") - 0.02) < 2e-3 &&
                   std::abs(report.column("tip_y_m") - 0.05) < 2e-3;
        },
        "it is at the path's end");
    std::ofstream(folder / "bad.csv") << "t,x,y,z\n0,0,0.9,0\n";
    window.enter("Hand/path", "bad.csv");
    EXPECT_TRUE(window.look().shows("out of the device's reach")) << window.look().texts();
    window.enter("Hand/path", "none.csv");
    EXPECT_TRUE(window.look().shows("none.csv"));
    std::filesystem::remove_all(folder);
}

TEST(PlantInTheWindow, TheHandMovesByKeys) {
    ShownWindow window({"--scene", testing::assets() / "scenes/plate.gltf"});
    window.wait_until_running();
    const double from_m = window.look().column("tip_y_m");
    for (int i = 0; i < 10; ++i) {
        window.person().key("e");
    }
    window.wait_until(
        [&](const Report &report) { return report.column("tip_y_m") > from_m + 5e-3; }, "up");
    for (int i = 0; i < 10; ++i) {
        window.person().key("shift+q");
    }
    // 10 mm up, 1 mm down; friction and weight hold the tip up to 0.7 mm from the hand's target.
    window.wait_until(
        [&](const Report &report) {
            return std::abs(report.column("tip_y_m") - from_m - 9e-3) < 8e-4;
        },
        "a little down");
}

} // namespace
} // namespace springdrive::app
