// Covers the keys, the servo panel's speed, limits and log: app/demo/screen.cpp,
// app/panels/servo_panel.cpp.
#include "engine/servo/safety_status.h"
#include "tests/support/devices.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <fstream>

namespace springdrive::app {
namespace {

using testing::Report;
using testing::ShownWindow;

double plots_height(const Report &report) { return report.item("Plots").at("height"); }

bool is_live(const Report &report) {
    return report.item("plot 1/area").at("numbers").at("is_live") == 1.0;
}

TEST(KeysInTheWindow, PauseStepAndGoOnWithTheSimulation) {
    ShownWindow window;
    window.wait_until_running();
    window.person().key("p");
    const Report paused = window.look();
    EXPECT_EQ(paused.item("speed").at("text"), "paused");
    const double tick = paused.column("tick");
    EXPECT_EQ(window.look().column("tick"), tick);
    window.person().key("period");
    EXPECT_EQ(window.look().column("tick"), tick + 1.0);
    window.click("step");
    EXPECT_EQ(window.look().column("tick"), tick + 2.0);
    window.choose("Servo/speed", "1/100");
    window.wait_until([&](const Report &report) { return report.column("tick") > tick + 5.0; },
                      "slow motion");
    window.choose("Servo/speed", "real time");
    window.wait_until([&](const Report &report) { return report.column("tick") > tick + 500.0; },
                      "real time");
    EXPECT_EQ(window.look().column("trip_cause"), 0.0);
}

TEST(KeysInTheWindow, F1EscapeHomeAndHoldDoWhatTheyDo) {
    ShownWindow window;
    window.wait_until_running();
    window.person().key("F1");
    EXPECT_TRUE(window.look().shows("emergency stop, at any time"));
    window.person().key("Escape");
    EXPECT_FALSE(window.look().shows("emergency stop, at any time"));
    const double height = plots_height(window.look());
    window.click("Plots/large");
    EXPECT_GT(plots_height(window.look()), 1.5 * height);
    window.person().key("Escape");
    EXPECT_EQ(plots_height(window.look()), height);
    EXPECT_TRUE(is_live(window.look()));
    window.person().key("h");
    EXPECT_FALSE(is_live(window.look()));
    window.person().key("h");
    EXPECT_TRUE(is_live(window.look()));
    window.person().key("Home");
    window.person().key("F11");
    window.person().key("F11");
    EXPECT_EQ(plots_height(window.look()), height);
}

TEST(KeysInTheWindow, LimitsShowWhatIsHeldAgainstThemAndTheLogWhatHappened) {
    ShownWindow window;
    window.wait_until_running();
    window.click("Servo/Limits");
    EXPECT_TRUE(window.look().shows("winding temperature"));
    EXPECT_EQ(window.look().item("tip_force_N/slider").at("value"), 8.5);
    window.person().key("F12");
    window.click("Servo/Log");
    window.wait_until([](const Report &report) { return report.shows("stopped: emergency stop"); },
                      "the log holds the stop");
    EXPECT_TRUE(window.look().shows("motors running"));
}

TEST(KeysInTheWindow, AForceThatIsHeldBackIsNamedWithItsLimit) {
    const std::filesystem::path folder = testing::fresh_folder("held_back");
    std::ofstream(folder / "deep.csv") << "t,x,y,z\n0,0,0.06,0\n1.5,0,0.06,0\n2.5,0,-0.05,0\n";
    ShownWindow window(
        {"--scene", testing::assets() / "scenes/plate.gltf", "--path", folder / "deep.csv"});
    window.wait_until([](const Report &report) { return report.column("force_y_N") > 3.0; },
                      "the hand presses");
    EXPECT_FALSE(window.look().shows("held back"));
    window.click("Servo/Limits");
    const testing::Point from = window.point_in("tip_force_N/slider", 0.97F);
    const testing::Point to = window.point_in("tip_force_N/slider", 0.25F);
    window.person().drag(from, to, 0.5);
    const Report held = window.wait_until(
        [](const Report &report) { return report.shows("held back: force"); }, "it is held back");
    const double limit_N = held.item("tip_force_N/slider").at("value");
    EXPECT_LT(limit_N, 4.0);
    // It glides to the limit within a second.
    window.wait_until([&](const Report &report) { return report.column("force_y_N") < limit_N; },
                      "below the limit");
}

TEST(KeysInTheWindow, PlotsAreZoomedAndMovedInTime) {
    ShownWindow window;
    window.wait_until_running();
    const auto shown = [&] {
        const auto plot = window.look().item("plot 1/area").at("numbers");
        return std::pair<double, double>(plot.at("x_from"), plot.at("x_to"));
    };
    window.person().key("h");
    const auto [from, to] = shown();
    window.person().key("minus");
    const auto [wide_from, wide_to] = shown();
    EXPECT_NEAR(wide_to - wide_from, 1.5 * (to - from), 1e-6);
    EXPECT_NEAR(wide_to + wide_from, to + from, 1e-6); // about the middle
    window.person().key("equal");
    window.person().key("Prior");
    const auto [early_from, early_to] = shown();
    EXPECT_NEAR(early_from, from - 0.25 * (to - from), 1e-6);
    window.person().key("Next");
    EXPECT_NEAR(shown().first, from, 1e-6);
}

/// The id of the item on which keys act; empty if there is none.
std::string focused(const Report &report) {
    for (const auto &item : report.all().at("items")) {
        if (item.value("focused", false)) {
            return item.at("id");
        }
    }
    return {};
}

/// Presses a key until the focus is on that item.
void go_to(ShownWindow &window, const std::string &id, const std::vector<std::string> &keys) {
    std::string passed;
    for (int i = 0; i < 40; ++i) {
        for (const std::string &key : keys) {
            window.person().key(key);
            const std::string now = focused(window.look());
            if (now.ends_with(id)) {
                return;
            }
            passed += now + '\n';
        }
    }
    FAIL() << id << " was not reached; passed were:\n" << passed;
}

TEST(KeysInTheWindow, WithoutAMouseGainsAreSetAndButtonsPressed) {
    ShownWindow window;
    window.wait_until_running();
    window.person().key("F6");
    EXPECT_TRUE(focused(window.look()).starts_with("Tuning")) << focused(window.look());
    go_to(window, "Gains/soft", {"Down", "Left"});
    const double before = window.look().item("K_P_V_per_rad/typed").at("value");
    window.person().key("Return");
    const double soft = window.look().item("K_P_V_per_rad/typed").at("value");
    EXPECT_NE(soft, before);
    go_to(window, "K_P_V_per_rad/slider", {"Down"});
    window.person().key("Return");
    window.person().key("Right");
    window.person().key("Return");
    EXPECT_GT(window.look().item("K_P_V_per_rad/typed").at("value"), soft);
    window.person().key("ctrl+z");
    EXPECT_EQ(window.look().item("K_P_V_per_rad/typed").at("value"), soft);
    go_to(window, "K_P_V_per_rad/typed", {"Right"});
    window.person().key("Return");
    window.person().key("ctrl+a");
    window.person().type("7.5");
    window.person().key("Return");
    EXPECT_EQ(window.look().item("K_P_V_per_rad/typed").at("value"), 7.5);
    window.person().key("ctrl+z");
    EXPECT_EQ(window.look().item("K_P_V_per_rad/typed").at("value"), soft);
    EXPECT_EQ(window.look().column("trip_cause"), 0.0);
    window.person().key("space"); // no widget takes the stop away
    EXPECT_NE(window.look().column("trip_cause"), 0.0);
}

} // namespace
} // namespace springdrive::app
