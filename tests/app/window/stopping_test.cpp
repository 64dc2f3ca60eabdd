// Covers what a person does to stop the device, and to start it again: app/window/window.cpp and
// app/panels/scene_overlay.cpp.
#include "engine/servo/safety_status.h"
#include "tests/support/devices.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <fstream>

namespace springdrive::app {
namespace {

using testing::Report;
using testing::ShownWindow;

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

TEST(StoppingInTheWindow, ByButtonByF12AndBySpaceUntilReset) {
    ShownWindow window;
    window.wait_until_running();
    window.click("stop/STOP  F12");
    expect_stop_and_reset(window, "the button");
    window.person().key("F12");
    expect_stop_and_reset(window, "F12");
    window.person().key("space");
    expect_stop_and_reset(window, "the space bar");
}

TEST(StoppingInTheWindow, NoTypedWordStopsButF12DoesWhileTyping) {
    ShownWindow window;
    window.wait_until_running();
    window.click("Scene/path");
    window.person().type("/tmp/my models/a b.gltf");
    EXPECT_FALSE(is_stopped(window.look()));
    window.person().key("F12");
    window.wait_until(is_stopped, "stopped while typing");
    window.person().key("Return"); // the path is still what was typed
    window.wait_until([](const Report &report) { return report.shows("a b.gltf"); },
                      "the window says that there is no such file");
}

TEST(StoppingInTheWindow, BelowTheKeysAndWhilePausedToo) {
    ShownWindow window;
    window.wait_until_running();
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
}

TEST(StoppingInTheWindow, AResetInContactSaysWhatIsMissing) {
    const std::filesystem::path folder = testing::fresh_folder("reset_in_contact");
    // Down into the plate, where it stays until the path's end, and a second longer.
    std::ofstream(folder / "down.csv") << "t,x,y,z\n0,0,0.06,0\n1.5,0,0.06,0\n2.5,0,-0.01,0\n";
    ShownWindow window(
        {"--scene", testing::assets() / "scenes/plate.gltf", "--path", folder / "down.csv"});
    window.wait_until([](const Report &report) { return report.column("touching") != 0.0; },
                      "the tip touches");
    window.person().key("F12");
    window.wait_until(is_stopped, "stopped");
    window.click("stopped/Reset");
    window.wait_until(
        [](const Report &report) {
            return report.find("waiting") && report.shows("until the tip is lifted off");
        },
        "the window says that the tip must be lifted");
    // The path is over: the hand moves again, and lifts the tip.
    window.wait_until(
        [](const Report &report) { return report.shows("left press on the scene: touch there"); },
        "the path has ended");
    window.person().press_key("Shift_L"); // in the view plane, wherever the drag begins
    window.person().drag({400.0F, 400.0F}, {400.0F, 200.0F}, 0.4);
    window.person().release_key("Shift_L");
    window.wait_until_running();
}

} // namespace
} // namespace springdrive::app
