// Covers the first minute: the plate below the scene, the messages over it with their buttons, and
// the tooltips of whole rows: app/demo/screen_overlay.cpp, app/panels/start_card.cpp,
// app/panels/scene_overlay.cpp, app/widgets/widgets.cpp.
#include "engine/servo/safety_status.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string>

namespace springdrive::app {
namespace {

using testing::Report;
using testing::ShownWindow;

bool shows_tooltip(const Report &report, const std::string &text) {
    return std::ranges::any_of(report.all().at("items"), [&](const auto &item) {
        return item.at("kind") == "tooltip" &&
               item.at("text").template get<std::string>().find(text) != std::string::npos;
    });
}

void expect_tooltip_at(ShownWindow &window, const testing::Point &point, const std::string &text) {
    window.person().move_to(point.x, point.y);
    window.wait_until([&](const Report &report) { return shows_tooltip(report, text); },
                      "the tooltip \"" + text + "\"");
}

TEST(FirstMinute, StandsBelowTheSceneUntilItIsDismissedForGood) {
    const std::filesystem::path folder = testing::fresh_folder("first_minute");
    {
        ShownWindow window({"--settings", folder / "settings"});
        window.wait_until_running();
        const Report report = window.look();
        EXPECT_TRUE(report.shows("No device is attached"));
        EXPECT_TRUE(report.shows("press where it is to touch"));
        EXPECT_TRUE(report.shows("press on the surface"));
        // Between the scene and the plots: it hides neither.
        const double top = report.item("Start").at("y");
        const double height = report.item("Start").at("height");
        EXPECT_NEAR(top + height, report.item("Plots").at("y").get<double>(), 1.0);
        window.click("Start/keys  F1");
        EXPECT_TRUE(window.look().shows("emergency stop, at any time"));
        window.person().key("Escape");
        window.click("Start/got it");
        EXPECT_FALSE(window.look().find("Start"));
        EXPECT_TRUE(window.look().shows("left press on the scene: touch there"));
    }
    EXPECT_NE(testing::contents_of(folder / "settings").find("dismissed_start = true"),
              std::string::npos);
    ShownWindow again({"--settings", folder / "settings"});
    again.wait_until_running();
    EXPECT_FALSE(again.look().find("Start"));
    again.click("window/menu");
    again.click("reset the settings");
    again.wait_until([](const Report &report) { return report.find("Start") != nullptr; },
                     "the plate is there again");
    EXPECT_FALSE(std::filesystem::exists(folder / "settings"));
    std::filesystem::remove_all(folder);
}

TEST(FirstMinute, IsNotForScriptsNorForDevices) {
    ShownWindow script;
    script.wait_until_running();
    EXPECT_FALSE(script.look().find("Start"));
    const std::filesystem::path folder = testing::fresh_folder("first_minute_device");
    setenv("XDG_STATE_HOME", folder.c_str(), 1); // NOLINT(concurrency-mt-unsafe)
    ShownWindow emulated({"--device", "emulated", "--at-zero", "--settings", folder / "settings"});
    unsetenv("XDG_STATE_HOME"); // NOLINT(concurrency-mt-unsafe)
    emulated.wait_until([](const Report &report) { return report.find("Plots") != nullptr; },
                        "the window is there");
    EXPECT_FALSE(emulated.look().find("Start"));
    std::filesystem::remove_all(folder);
}

/// A hand that holds still there, and can be moved after a moment.
std::filesystem::path held_at(const std::filesystem::path &folder, const char *place) {
    std::ofstream(folder / "held.csv") << "t,x,y,z\n0," << place << "\n0.2," << place << '\n';
    return folder / "held.csv";
}

TEST(SceneMessagesInTheWindow, ATipThatStartsInsideIsPulledOutByTheButton) {
    const std::filesystem::path folder = testing::fresh_folder("starts_inside");
    ShownWindow window({"--scene", testing::assets() / "scenes/plate.gltf", "--path",
                        held_at(folder, "0,-0.009,0")});
    window.wait_until(
        [](const Report &report) { return report.find("inside/pull it out") != nullptr; },
        "the tip is inside");
    EXPECT_TRUE(window.look().shows("The tip is inside: pull out."));
    const double before_m = window.look().column("tip_y_m");
    window.click("inside/pull it out");
    const Report out = window.wait_until(
        [](const Report &report) { return report.find("inside") == nullptr; }, "it is out");
    EXPECT_GT(out.column("tip_y_m"), before_m);
    EXPECT_EQ(out.column("trip_cause"), 0.0);
    window.wait_until_running();
    EXPECT_FALSE(window.look().shows("inside"));
}

TEST(SceneMessagesInTheWindow, ATipThatRestsOnTheSurfaceIsLiftedByTheButton) {
    const std::filesystem::path folder = testing::fresh_folder("lifted");
    std::ofstream(folder / "down.csv") << "t,x,y,z\n0,0,0.06,0\n1.5,0,0.06,0\n2.5,0,-0.01,0\n";
    ShownWindow window(
        {"--scene", testing::assets() / "scenes/plate.gltf", "--path", folder / "down.csv"});
    window.wait_until([](const Report &report) { return report.column("touching") != 0.0; },
                      "the tip touches");
    window.person().key("F12");
    window.click("stopped/Reset");
    window.wait_until(
        [](const Report &report) { return report.find("waiting/lift the tip") != nullptr; },
        "the path is over, and the button is there");
    EXPECT_TRUE(window.look().shows("Lift the tip to start."));
    window.click("waiting/lift the tip");
    window.wait_until_running();
    EXPECT_EQ(window.look().column("touching"), 0.0);
}

TEST(SceneMessagesInTheWindow, APauseAndAStopSayHowToGoOn) {
    ShownWindow window;
    window.wait_until_running();
    window.person().key("p");
    EXPECT_TRUE(window.look().shows("Paused: the device stands still."));
    window.person().key("F12");
    const Report stopped = window.look();
    EXPECT_TRUE(stopped.shows("Stopped: emergency stop"));
    EXPECT_FALSE(stopped.find("paused/go on  P")); // one at a time
    window.click("stopped/Reset");
    window.click("paused/go on  P");
    window.wait_until_running();
    EXPECT_EQ(window.look().item("speed").at("text"), "real time");
}

TEST(Tooltips, AppearAnywhereOnTheRowOfAParameter) {
    ShownWindow window;
    window.wait_until_running();
    for (const auto &[row, paper] : std::initializer_list<std::pair<std::string, std::string>>{
             {"dR_Ohm", "residual uncanceled resistance"},
             {"K_P_V_per_rad", "equations (10), (13) of the paper"},
             {"eta", "0 rigid contact, 1 freespace"}}) {
        const testing::Point slider = window.point_in(row + "/slider");
        const testing::Point reset = window.point_in(row + "/reset");
        expect_tooltip_at(window, slider, paper);
        expect_tooltip_at(window, window.point_in(row + "/typed"), paper);
        expect_tooltip_at(window, {reset.x - 24.0F, reset.y}, paper); // beside the unit
        expect_tooltip_at(window, window.point_in(row + "/slider", -0.2F), paper);
    }
    expect_tooltip_at(window, window.point_in("dR_Ohm/reset"), "reset to 0.5");
    EXPECT_FALSE(shows_tooltip(window.look(), "residual uncanceled")); // an item's own goes first
    expect_tooltip_at(window, window.point_in("Gains/map"), "key M switches");
    expect_tooltip_at(window, window.point_in("K_DC", 0.3F), "static stiffness");
    window.click("Servo/Limits");
    expect_tooltip_at(window, window.point_in("tip_force_N/slider"), "tip force");
}

TEST(Tooltips, AreNotInTheWayOfADrag) {
    ShownWindow window;
    window.wait_until_running();
    const testing::Point slider = window.point_in("K_P_V_per_rad/slider");
    expect_tooltip_at(window, slider, "error gain");
    window.person().press();
    EXPECT_FALSE(shows_tooltip(window.look(), "error gain"));
    window.person().release();
    expect_tooltip_at(window, slider, "error gain");
}

TEST(Tooltips, OfChannelsSayUnitAndEquation) {
    ShownWindow window;
    window.wait_until_running();
    expect_tooltip_at(window, window.point_in("plot 2/force_N"), "equations (3), (22)");
    EXPECT_TRUE(shows_tooltip(window.look(), "unit: N"));
    window.click("plot 1/menu");
    expect_tooltip_at(window, window.point_in("menu/measured_s"), "by the device's clock");
}

} // namespace
} // namespace springdrive::app
