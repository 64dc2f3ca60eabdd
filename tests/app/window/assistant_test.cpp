// Covers app/assistant/assistant_panel.cpp: the assistant as somebody walks through it with mouse
// and keyboard, on an emulated device.
#include "base/quoting.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
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
    /// As if it had been there before.
    void open_at(const std::vector<std::string> &done, std::vector<std::string> arguments) {
        const std::filesystem::path folder = state_ / "springdrive" / "assistant";
        std::filesystem::create_directories(folder);
        std::ofstream(folder / "emulated-emulated.toml")
            << "done = " << toml_list(done) << "\nfailed = []\n";
        open(std::move(arguments));
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
    /// Up to its result.
    Report test() {
        press("self_test/start");
        window().wait_until(
            [](const Report &report) { return report.find("self_test/stop") != nullptr; },
            "it runs");
        return window().wait_until(
            [](const Report &report) { return report.find("self_test/stop") == nullptr; },
            "it is over", 120.0);
    }
    Report test_of_zeroed(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), "--at-zero");
        open_at({"link", "identity", "motion", "zeroing"}, std::move(arguments));
        return test();
    }

private:
    std::filesystem::path state_;
    std::unique_ptr<ShownWindow> window_;
};

TEST_F(AssistantInTheWindow, LeadsAHealthyDeviceToItsFirstTouchAndDoesNotComeAgain) {
    open();
    next();
    next();
    confirm_joints();
    next();
    zero();
    next();
    const Report tested = test();
    EXPECT_TRUE(tested.shows("Nothing was found")) << tested.texts();
    next();
    press("calibration/skip");
    next();
    press(std::string("touch/") + kByHand);
    next();
    window().wait_until_running(); // the ordinary panels are back
    EXPECT_EQ(window().look().column("trip_cause"), 0.0);
    open({"--at-zero"});
    window().wait_until_running();
    EXPECT_EQ(window().look().find("Assistant"), nullptr);
    window().click("Scene/Plant");
    window().click("Plant/assistant…");
    EXPECT_NE(window().look().find("Assistant/Leave"), nullptr);
}

TEST_F(AssistantInTheWindow, IsLeftAndResumedWhereItWas) {
    open();
    next();
    next();
    window().click("Assistant/Leave");
    const Report left = window().look();
    EXPECT_EQ(left.find("Assistant"), nullptr);
    EXPECT_TRUE(left.shows("waiting to be zeroed")) << left.texts();
    open();
    EXPECT_TRUE(window().look().shows("3 of 7: Free motion"));
    window().click("Assistant/Back");
    EXPECT_TRUE(window().look().shows("2 of 7: Identity"));
    window().click("steps/link");
    EXPECT_TRUE(window().look().shows("1 of 7: Connection"));
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

TEST_F(AssistantInTheWindow, AnOpenWindingIsFoundAndNotPassed) {
    const Report result = test_of_zeroed({"--fault", "open-winding:2"});
    EXPECT_TRUE(result.shows("must not be driven")) << result.texts();
    EXPECT_TRUE(result.shows("motor 2 draws hardly any current")) << result.texts();
    EXPECT_FALSE(is_enabled(result, "Assistant/Next"));
    EXPECT_EQ(result.find("continue all the same"), nullptr);
}

/// And F12 within the self-test.
TEST_F(AssistantInTheWindow, APulledCableAndAStopAreNamedAndTheStepIsDoneAgain) {
    open_at({"link", "identity", "motion", "zeroing"}, {"--at-zero", "--fault", "unplug@14-16"});
    press("self_test/start");
    window().wait_until([](const Report &report) { return report.shows("the device is lost"); },
                        "it is unplugged", 60.0);
    EXPECT_FALSE(is_enabled(window().look(), "Assistant/Next"));
    window().wait_until([](const Report &report) { return !report.shows("the device is lost"); },
                        "it is plugged in again");
    window().click("Assistant/Again");
    press("self_test/start");
    window().wait_until(
        [](const Report &report) { return report.find("self_test/stop") != nullptr; }, "it runs");
    window().person().key("F12");
    const Report stopped = window().wait_until(
        [](const Report &report) { return report.shows("stopped: emergency stop"); }, "stopped");
    EXPECT_EQ(stopped.find("self_test/stop"), nullptr);
    window().click("Assistant/Again");
    press("self_test/start");
    window().wait_until(
        [](const Report &report) { return report.find("self_test/stop") != nullptr; }, "it runs");
    window().person().key("Escape");
    window().wait_until([](const Report &report) { return report.shows("stopped before its end"); },
                        "ended");
}

/// On a loan of its own thread, stopped by a key, and then to its end.
TEST_F(AssistantInTheWindow, ADeviceIsCalibratedAndItsBoardKeepsIt) {
    open_at({"link", "identity", "motion", "zeroing", "self_test"}, {"--at-zero"});
    press("calibration/start");
    window().wait_until(
        [](const Report &report) { return is_enabled(report, "calibration/that is enough"); },
        "it is moved by hand", 60.0);
    window().person().key("Escape");
    const Report stopped = window().wait_until(
        [](const Report &report) { return report.shows("stopped before its end"); }, "ended");
    EXPECT_TRUE(stopped.shows("nothing was kept")) << stopped.texts();
    EXPECT_FALSE(is_enabled(stopped, "Assistant/Next"));
    press("calibration/calibrate again");
    const Report done =
        window().wait_until([](const Report &report) { return report.shows("kept by the board"); },
                            "it is calibrated", 240.0);
    EXPECT_TRUE(done.shows("motor 3: R 2.1")) << done.texts(); // 2.18 Ω of the file's motors
    press("Assistant/Again");
    EXPECT_TRUE(window().look().shows("kept by the board"));
    next();
    EXPECT_TRUE(window().look().shows("7 of 7"));
}

} // namespace
} // namespace springdrive::app
