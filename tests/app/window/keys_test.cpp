// Covers the keys, what stops the device, tooltips, and the servo panel's speed, limits, log and
// doctor: app/demo/screen.cpp, app/window/window.cpp, app/widgets/widgets.cpp,
// app/panels/servo_panel.cpp, scene_overlay.cpp and doctor_popup.cpp.
#include "engine/servo/safety_status.h"
#include "tests/support/devices.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <linux/capability.h>
#include <string>
#include <sys/prctl.h>
#include <thread>

namespace springdrive::app {
namespace {

using testing::Report;
using testing::ShownWindow;

double plots_height(const Report &report) { return report.item("Plots").at("height"); }

bool is_live(const Report &report) {
    return report.item("plot 1/area").at("numbers").at("is_live") == 1.0;
}

TEST(KeysInTheWindow, PauseStepOpenCloseHoldAndZoom) {
    ShownWindow window;
    window.wait_until_running();
    EXPECT_FALSE(window.look().find("Start")); // not without settings, as scripts run it
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
    // Time in the plots.
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
    // Limits show what is held against them, and the log what happened.
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

// --- stops ---

bool is_stopped(const Report &report) {
    return report.column("safety_state") == static_cast<double>(servo::SafetyState::tripped);
}

void expect_stop_and_reset(ShownWindow &window, const std::string &what) {
    const Report stopped = window.wait_until(is_stopped, "stopped by " + what);
    EXPECT_EQ(stopped.column("trip_cause"), static_cast<double>(servo::TripCause::emergency_stop));
    EXPECT_TRUE(stopped.shows("Stopped: emergency stop"));
    window.click("stopped/Reset");
    window.wait_until_running();
}

TEST(StoppingInTheWindow, ByButtonF12AndSpaceAlsoBelowTheKeysPausedAndWhileTyping) {
    ShownWindow window;
    window.wait_until_running();
    window.click("stop/STOP  F12");
    expect_stop_and_reset(window, "the button");
    window.person().key("F12");
    expect_stop_and_reset(window, "F12");
    window.person().key("space");
    expect_stop_and_reset(window, "the space bar");
    // Below the keys, and while paused.
    window.person().key("F1");
    window.click("stop/STOP  F12");
    expect_stop_and_reset(window, "the button while the keys are shown");
    window.person().key("p");
    window.person().key("F12");
    EXPECT_TRUE(is_stopped(window.look()));
    EXPECT_TRUE(window.look().shows("paused"));
    window.click("stopped/Reset");
    window.person().key("p");
    window.wait_until_running();
    // One message at a time.
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
    // No typed word stops, but F12 does.
    window.click("Scene/path");
    window.person().type("/tmp/my models/a b.gltf");
    EXPECT_FALSE(is_stopped(window.look()));
    window.person().key("F12");
    window.wait_until(is_stopped, "stopped while typing");
    window.person().key("Return"); // the path is still what was typed
    window.wait_until([](const Report &report) { return report.shows("a b.gltf"); },
                      "the window says that there is no such file");
}

// --- tooltips ---

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

TEST(Tooltips, AppearOnTheWholeRowButNotInTheWayOfADrag) {
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
    // Of channels, with unit and equation.
    expect_tooltip_at(window, window.point_in("plot 2/force_N"), "equations (3), (22)");
    EXPECT_TRUE(shows_tooltip(window.look(), "unit: N"));
    window.click("plot 1/menu");
    expect_tooltip_at(window, window.point_in("menu/measured_s"), "by the device's clock");
    const testing::Point title = window.point_in("Servo", 0.5F, 0.02F); // nothing to click on
    window.person().click(title.x, title.y);
    // Not in the way of a drag.
    const testing::Point gain = window.point_in("K_P_V_per_rad/slider");
    expect_tooltip_at(window, gain, "error gain");
    window.person().press();
    EXPECT_FALSE(shows_tooltip(window.look(), "error gain"));
    window.person().release();
    expect_tooltip_at(window, gain, "error gain");
}

// --- doctor ---

bool shows_answer(const Report &report) { return report.shows("disk for records in"); }

/// Of this thread, and of the programs that it starts, also where they run as root.
void give_up_real_time() {
    prctl(PR_CAPBSET_DROP, CAP_SYS_NICE, 0, 0, 0);
    prctl(PR_CAPBSET_DROP, CAP_IPC_LOCK, 0, 0, 0);
}

TEST(DoctorInTheWindow, IsOfferedBesideWhatWasRefusedAndGivesItsLine) {
    std::thread([] {
        give_up_real_time();
        ShownWindow window;
        window.wait_until_running();
        const Report before = window.look();
        if (!before.shows("no real-time priority")) {
            return; // an ordinary user to whom it is granted
        }
        const double ticks = before.column("tick");
        window.click("Servo/doctor…");
        const Report answer = window.wait_until(shows_answer, "the doctor's answer");
        EXPECT_TRUE(answer.shows("SCHED_FIFO 80 refused")) << answer.texts();
        EXPECT_NE(answer.find("real-time priority/copy"), nullptr) << answer.texts();
        EXPECT_GT(answer.column("tick"), ticks); // the servo went on
        EXPECT_EQ(answer.column("trip_cause"), 0.0);
        window.click("Doctor/close");
        window.wait_until([](const Report &report) { return !shows_answer(report); }, "closed");
    }).join();
}

} // namespace
} // namespace springdrive::app
