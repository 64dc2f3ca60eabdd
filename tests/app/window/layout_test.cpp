// Covers what fits where: no panel may clip or overlap its contents at any size of the window.
#include "base/quoting.h"
#include "tests/support/devices.h"
#include "tests/support/program.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

using testing::Report;
using testing::ShownWindow;

struct Box {
    std::string id;
    std::string text;
    double left, top, right, bottom;
};

/// What a reader would see of the report's widgets, panels apart.
std::vector<Box> boxes_of(const Report &report) {
    static const std::set<std::string> kSurfaces{"panel", "tooltip", "drawing"};
    std::vector<Box> boxes;
    for (const auto &item : report.all().at("items")) {
        if (kSurfaces.contains(item.at("kind")) || !item.value("visible", true)) {
            continue;
        }
        boxes.push_back({item.at("id"), item.at("text"), item.at("x"), item.at("y"),
                         item.at("x").get<double>() + item.at("width").get<double>(),
                         item.at("y").get<double>() + item.at("height").get<double>()});
    }
    return boxes;
}

bool overlap(const Box &a, const Box &b) {
    constexpr double kRounding = 1.0; // of places to pixels
    return std::min(a.right, b.right) - std::max(a.left, b.left) > kRounding &&
           std::min(a.bottom, b.bottom) - std::max(a.top, b.top) > kRounding;
}

void expect_all_fits(const Report &report, const std::string &where) {
    for (const auto &item : report.all().at("items")) {
        EXPECT_FALSE(item.value("overflows", false)) << where << ": " << item.dump();
    }
    const std::vector<Box> boxes = boxes_of(report);
    const double width = report.all().at("window").at("width");
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        EXPECT_LE(boxes[i].right, width + 1.0) << where << ": " << boxes[i].id;
        for (std::size_t j = i + 1; j < boxes.size(); ++j) {
            EXPECT_FALSE(overlap(boxes[i], boxes[j]))
                << where << ": \"" << boxes[i].id << "\" (" << boxes[i].text << ") and \""
                << boxes[j].id << "\" (" << boxes[j].text << ")";
        }
    }
}

/// Once what is shown has stayed the same for a look: a table that has just appeared, with what was
/// computed in the background, fits a frame later.
Report settled(ShownWindow &window) {
    const auto ids_of = [](const Report &report) {
        std::vector<std::string> ids;
        for (const auto &item : report.all().at("items")) {
            ids.push_back(item.at("id"));
        }
        return ids;
    };
    std::vector<std::string> before;
    return window.wait_until(
        [&](const Report &report) {
            std::vector<std::string> now = ids_of(report);
            return now == std::exchange(before, now);
        },
        "all is there");
}

class Layout : public ::testing::TestWithParam<testing::WindowSize> {};

TEST_P(Layout, NoPanelClipsOrOverlapsItsContents) {
    ShownWindow window({}, GetParam());
    window.wait_until_running();
    const Report first = window.look();
    expect_all_fits(first, "as it opens");
    std::vector<std::string> closed_tabs;
    for (const auto &item : first.all().at("items")) {
        if (item.at("kind") == "tab" && !item.at("value").get<bool>()) {
            closed_tabs.push_back(item.at("id"));
        }
    }
    EXPECT_FALSE(closed_tabs.empty());
    for (const std::string &tab : closed_tabs) {
        window.click(tab);
        expect_all_fits(settled(window), tab);
    }
}

TEST_P(Layout, ARecordFitsWithWhatOtherGainsWouldHaveDone) {
    const std::filesystem::path folder = testing::fresh_folder("layout_record");
    const std::filesystem::path file = folder / "touch.rec";
    ASSERT_EQ(testing::run_program({"record", file, "--lockstep", "--seconds", "3"}).exit_status,
              0);
    ShownWindow window(
        {"--open", file, "--kp", "7", "--scene", testing::assets() / "scenes/plate.gltf"},
        GetParam(), folder);
    window.wait_until(
        [](const Report &report) { return report.find("record/position") != nullptr; }, "shown");
    window.click("Scene/Record");
    window.click("Record/what if: the active tuning");
    window.wait_until([](const Report &report) { return report.shows("active tuning"); },
                      "answered");
    expect_all_fits(settled(window), "a record");
    window.person().key("ctrl+s");
    window.wait_until([](const Report &report) { return report.find("Servo/kept") != nullptr; },
                      "kept");
    expect_all_fits(settled(window), "kept");
    std::filesystem::remove_all(folder);
}

TEST_P(Layout, TheFirstMinuteFitsWithAndWithoutPanels) {
    const std::filesystem::path folder = testing::fresh_folder("layout_start");
    ShownWindow window({"--settings", folder / "settings"}, GetParam());
    window.wait_until_running();
    EXPECT_TRUE(window.look().find("Start/got it"));
    expect_all_fits(settled(window), "with panels");
    window.person().key("F10");
    // Until the notice that stands over the scene is gone.
    window.wait_until([](const Report &report) { return !report.shows("F10 shows the panels"); },
                      "the notice goes");
    EXPECT_TRUE(window.look().find("Start/got it"));
    EXPECT_TRUE(window.look().find("read-outs/force"));
    expect_all_fits(settled(window), "without panels");
    std::filesystem::remove_all(folder);
}

/// The steps that say most, in all their states but the end of a self-test.
TEST_P(Layout, TheAssistantFits) {
    const std::filesystem::path state = testing::fresh_folder("layout_assistant");
    setenv("XDG_STATE_HOME", state.c_str(), 1); // NOLINT(concurrency-mt-unsafe)
    const std::filesystem::path progress = state / "springdrive" / "assistant";
    std::filesystem::create_directories(progress);
    const std::vector<std::string> steps{"link",      "identity",    "motion", "zeroing",
                                         "self_test", "calibration", "touch"};
    std::ofstream(progress / "emulated-emulated.toml")
        << "done = " << toml_list(steps) << "\nfailed = []\n";
    ShownWindow window({"--device", "emulated", "--at-zero", "--assistant"}, GetParam());
    unsetenv("XDG_STATE_HOME"); // NOLINT(concurrency-mt-unsafe)
    for (const std::string &step : steps) {
        window.click("steps/" + step);
        expect_all_fits(settled(window), step);
    }
    window.click("steps/self_test");
    window.click("self_test/start");
    window.wait_until([](const Report &report) { return report.find("self_test/stop") != nullptr; },
                      "it runs");
    expect_all_fits(settled(window), "self-test");
    window.person().key("F12");
    window.wait_until([](const Report &report) { return report.shows("stopped: emergency stop"); },
                      "stopped");
    expect_all_fits(settled(window), "stopped");
    window.click("Assistant/Again");
    window.click("steps/motion");
    window.click("motion/nothing moves");
    expect_all_fits(settled(window), "nothing moves");
    std::filesystem::remove_all(state);
}

INSTANTIATE_TEST_SUITE_P(Sizes, Layout,
                         ::testing::Values(testing::WindowSize{640, 400, 1.0},
                                           testing::WindowSize{1280, 720, 1.0},
                                           testing::WindowSize{2560, 1440, 2.0}),
                         [](const auto &size) { return std::to_string(size.param.width); });

} // namespace
} // namespace springdrive::app
