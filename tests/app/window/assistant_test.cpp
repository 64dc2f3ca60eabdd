// Covers app/assistant/assistant_panel.cpp: the assistant as somebody walks through it with mouse
// and keyboard, on an emulated device.
#include "tests/support/devices.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

using testing::Report;
using testing::ShownWindow;

constexpr const char *kByHand = "let the simulated hand do it";

bool is_enabled(const Report &report, const std::string &id) {
    const nlohmann::json *const item = report.find(id);
    return item != nullptr && item->value("enabled", true);
}

/// With a folder of its own for the progress of devices.
class AssistantInTheWindow : public ::testing::Test {
protected:
    AssistantInTheWindow() : state_(testing::fresh_folder("assistant_state")) {
        setenv("XDG_STATE_HOME", state_.c_str(), 1); // NOLINT(concurrency-mt-unsafe)
    }
    ~AssistantInTheWindow() override {
        unsetenv("XDG_STATE_HOME"); // NOLINT(concurrency-mt-unsafe)
        std::filesystem::remove_all(state_);
    }
    AssistantInTheWindow(const AssistantInTheWindow &) = delete;
    AssistantInTheWindow &operator=(const AssistantInTheWindow &) = delete;

    void open(std::vector<std::string> arguments = {}) {
        arguments.insert(arguments.begin(), {"--device", "emulated"});
        window_ = std::make_unique<ShownWindow>(std::move(arguments));
    }

    ShownWindow &window() { return *window_; }
    void press(const std::string &id, double limit_s = 30.0) {
        window().wait_until([&](const Report &report) { return is_enabled(report, id); },
                            id + " can be pressed", limit_s);
        window().click(id);
    }
    void next() { press("Assistant/Next"); }
    void confirm_joints() {
        for (int joint = 0; joint < 3; ++joint) {
            press(std::string("motion/") + kByHand);
            press("motion/yes, the same way");
        }
    }
    void zero() {
        press(std::string("zeroing/") + kByHand);
        press("zeroing/zero here");
        window().wait_until([](const Report &report) { return report.shows("zeroed;"); },
                            "it is zeroed");
    }
    void start_test() {
        press("self_test/start");
        window().wait_until(
            [](const Report &report) { return report.find("self_test/stop") != nullptr; },
            "it runs");
    }
    Report wait_for(const std::string &text) {
        return window().wait_until([&](const Report &report) { return report.shows(text); }, text);
    }

    std::filesystem::path state_;

private:
    std::unique_ptr<ShownWindow> window_;
};

/// Left and resumed on the way, with a self-test that is stopped and one that is ended, and a
/// calibration that is ended, before those that count.
TEST_F(AssistantInTheWindow, LeadsAHealthyDeviceToItsFirstTouchAndDoesNotComeAgain) {
    open();
    next();
    next();
    window().click("Assistant/Leave");
    const Report left = window().look();
    EXPECT_EQ(left.find("Assistant"), nullptr);
    EXPECT_TRUE(left.shows("waiting to be zeroed")) << left.texts();
    open(); // where it was
    EXPECT_TRUE(window().look().shows("3 of 7: Free motion"));
    window().click("Assistant/Back");
    EXPECT_TRUE(window().look().shows("2 of 7: Identity"));
    window().click("steps/link");
    EXPECT_TRUE(window().look().shows("1 of 7: Connection"));
    next();
    next();
    confirm_joints();
    next();
    zero();
    next();
    start_test();
    window().person().key("F12");
    const Report stopped = wait_for("stopped: emergency stop");
    EXPECT_EQ(stopped.find("self_test/stop"), nullptr);
    window().click("Assistant/Again");
    start_test();
    window().person().key("Escape");
    wait_for("stopped before its end");
    window().click("Assistant/Again");
    start_test();
    const Report tested = window().wait_until(
        [](const Report &report) { return report.find("self_test/stop") == nullptr; }, "it is over",
        120.0);
    EXPECT_TRUE(tested.shows("Nothing was found")) << tested.texts();
    next();
    press("calibration/start"); // on an exclusive use of its own thread
    window().wait_until(
        [](const Report &report) { return is_enabled(report, "calibration/that is enough"); },
        "it is moved by hand", 60.0);
    window().person().key("Escape");
    const Report ended = wait_for("stopped before its end");
    EXPECT_TRUE(ended.shows("nothing was kept")) << ended.texts();
    EXPECT_FALSE(is_enabled(ended, "Assistant/Next"));
    press("calibration/skip");
    next();
    press(std::string("touch/") + kByHand);
    next();
    window().wait_until_running(); // the ordinary panels are back
    EXPECT_EQ(window().look().column("trip_cause"), 0.0);
    open({"--at-zero", "--settings", (state_ / "settings").string()});
    window().wait_until_running();
    EXPECT_EQ(window().look().find("Assistant"), nullptr);
    EXPECT_EQ(window().look().find("Start"), nullptr); // the first minute is for the simulation
    window().click("Scene/Plant");
    window().click("Plant/assistant…");
    EXPECT_NE(window().look().find("Assistant/Leave"), nullptr);
}

TEST_F(AssistantInTheWindow, AMirroredChannelIsNamedByWhoSeesIt) {
    open({"--fault", "reversed-encoder:1"});
    next();
    next();
    press(std::string("motion/") + kByHand);
    window().wait_until([](const Report &report) { return report.shows("moved to the left"); },
                        "the picture goes the other way");
    press("motion/no, the other way");
    const Report named = window().look();
    EXPECT_TRUE(named.shows("channel 1 is mirrored")) << named.texts();
    EXPECT_FALSE(is_enabled(named, "Assistant/Next"));
    window().click("Assistant/Leave");
    window().click("Scene/Plant");
    EXPECT_TRUE(window().look().shows("The device only brakes"));
}

} // namespace
} // namespace springdrive::app
