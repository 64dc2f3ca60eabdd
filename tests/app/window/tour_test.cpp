// Covers Guide of app/exhibit/scripted demo.cpp: the tour in the ordinary window.
#include "engine/servo/safety_status.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

namespace springdrive::app {
namespace {

using testing::Report;
using testing::ShownWindow;

TEST(TourInTheWindow, TouchesTheFirstSceneAndEndsWithEscape) {
    ShownWindow window;
    window.wait_until_running();
    const double K_P = window.look().column("K_P_V_per_rad");
    window.click("window/menu");
    window.click("tour of the scenes");
    window.wait_until([](const Report &report) { return report.shows("A stiff wall"); },
                      "the first scene");
    window.wait_until([](const Report &report) { return report.column("touching") != 0.0; },
                      "the scripted hand touches it");
    EXPECT_TRUE(window.look().shows("the hand follows a path"));
    window.person().key("Escape");
    window.wait_until([](const Report &report) { return report.shows("left press on the scene"); },
                      "the hand is its user's");
    const Report after = window.look();
    EXPECT_EQ(after.column("K_P_V_per_rad"), K_P);
    EXPECT_EQ(after.column("safety_state"), static_cast<double>(servo::SafetyState::running));
    EXPECT_NE(after.find("Tuning"), nullptr);
}

} // namespace
} // namespace springdrive::app
