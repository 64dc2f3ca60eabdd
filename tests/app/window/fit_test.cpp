// Covers what fits where, at any size of the window: no panel, menu or plate may clip or overlap
// its contents, or what stands beside it.
#include "base/text.h"
#include "tests/support/devices.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

using testing::Point;
using testing::Report;
using testing::ShownBox;
using testing::ShownWindow;

ShownBox box_of(const nlohmann::json &item) {
    const double left = item.at("x");
    const double top = item.at("y");
    return {item.at("id"),
            item.at("text"),
            left,
            top,
            left + item.at("width").get<double>(),
            top + item.at("height").get<double>()};
}

Point middle_of(const nlohmann::json &item) {
    const ShownBox box = box_of(item);
    return {static_cast<float>(0.5 * (box.left + box.right)),
            static_cast<float>(0.5 * (box.top + box.bottom))};
}

/// All that a reader would see, panels and drawings apart.
void expect_all_fits(const Report &report, const std::string &where) {
    for (const auto &item : report.all().at("items")) {
        EXPECT_FALSE(item.value("overflows", false)) << where << ": " << item.dump();
    }
    std::vector<ShownBox> boxes = testing::shown_boxes(report, "");
    std::erase_if(boxes,
                  [&](const ShownBox &box) { return report.item(box.id).at("kind") == "drawing"; });
    const double width = report.all().at("window").at("width");
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        EXPECT_LE(boxes[i].right, width + 1.0) << where << ": " << boxes[i].id;
        for (std::size_t j = i + 1; j < boxes.size(); ++j) {
            EXPECT_FALSE(testing::overlap(boxes[i], boxes[j]))
                << where << ": \"" << boxes[i].id << "\" (" << boxes[i].text << ") and \""
                << boxes[j].id << "\" (" << boxes[j].text << ")";
        }
    }
}

/// Once what is shown has stayed the same for a look: a table that has just appeared, with what was
/// computed in the background, fits a frame later.
Report settled(ShownWindow &window) {
    std::vector<std::string> before;
    return window.wait_until(
        [&](const Report &report) {
            std::vector<std::string> now;
            for (const auto &item : report.all().at("items")) {
                now.push_back(item.at("id"));
            }
            return now == std::exchange(before, now);
        },
        "all is there");
}

/// Device and scene are within the window, and nothing is drawn over them.
void expect_whole(const Report &report, const std::string &when) {
    const ShownBox drawing = box_of(report.item("device and scene"));
    EXPECT_GT(drawing.left, 0.0) << when;
    EXPECT_GT(drawing.top, 0.0) << when;
    int others = 0;
    for (const auto &item : report.all().at("items")) {
        const std::string kind = item.at("kind");
        if (kind != "drawing" && kind != "tooltip") {
            ++others;
            const ShownBox box = box_of(item);
            EXPECT_FALSE(std::min(drawing.right, box.right) > std::max(drawing.left, box.left) &&
                         std::min(drawing.bottom, box.bottom) > std::max(drawing.top, box.top))
                << when << ": " << item.dump();
        }
    }
    EXPECT_GT(others, 20) << when;
}

/// Of a menu; the entries of its list are clipped.
void expect_within_window(ShownWindow &window, const std::string &scope) {
    (void)window.look(); // it finds its place
    const Report report = window.look();
    const auto &size = report.all().at("window");
    int items = 0;
    for (const auto &item : report.all().at("items")) {
        const ShownBox box = box_of(item);
        if (box.id.starts_with(scope) && item.at("kind") != "entry") {
            ++items;
            EXPECT_GE(box.left, 0.0) << box.id;
            EXPECT_GE(box.top, 0.0) << box.id;
            EXPECT_LE(box.right, size.at("width").get<double>()) << box.id;
            EXPECT_LE(box.bottom, size.at("height").get<double>()) << box.id;
        }
    }
    EXPECT_GT(items, 3) << scope;
}

/// @return how many there are
int expect_plots_within_their_places(const Report &report, const std::string &set) {
    testing::expect_side_by_side(report, "Plots", set);
    int plots = 0;
    for (const auto &item : report.all().at("items")) {
        if (item.at("kind") == "plot") {
            ++plots;
            const ShownBox place = box_of(item);
            const auto &numbers = item.at("numbers");
            const double height = numbers.at("area_height");
            EXPECT_LE(numbers.at("area_x").get<double>() + numbers.at("area_width").get<double>(),
                      place.right + 1.0)
                << set << ", " << place.id;
            EXPECT_LE(numbers.at("area_y").get<double>() + height, place.bottom + 1.0)
                << set << ", " << place.id;
            EXPECT_GT(height, 12.0) << set << ", " << place.id;
        }
    }
    return plots;
}

class Layout : public ::testing::TestWithParam<testing::WindowSize> {
protected:
    /// One for all sizes.
    static void SetUpTestSuite() {
        folder_ = testing::fresh_folder("layout");
        ASSERT_EQ(
            testing::run_program({"record", folder_ / "touch.rec", "--lockstep", "--seconds", "3"})
                .exit_status,
            0);
    }

    inline static std::filesystem::path folder_;
};

TEST_P(Layout, ViewPanelsPlotsAndLegendFit) {
    const std::filesystem::path settings = folder_ / std::to_string(GetParam().width);
    ShownWindow window(
        {"--settings", settings, "--scene", testing::assets() / "scenes/stepped_block.gltf"},
        GetParam());
    window.wait_until_running();
    // The first minute.
    EXPECT_TRUE(window.look().find("Start/got it"));
    expect_all_fits(settled(window), "with the first minute");
    window.person().key("F10");
    window.wait_until([](const Report &report) { return !report.shows("F10 shows the panels"); },
                      "the notice goes");
    EXPECT_TRUE(window.look().find("Start/got it"));
    EXPECT_TRUE(window.look().find("read-outs/force"));
    expect_all_fits(settled(window), "without panels");
    window.person().key("F10");
    window.click("Start/got it");
    // The view.
    const Report first = settled(window);
    expect_whole(first, "at the start");
    const ShownBox home = box_of(first.item("device and scene"));
    window.person().key("t");
    expect_whole(window.look(), "from above");
    window.click("view/front");
    window.person().move_to(5.0F, static_cast<float>(home.bottom)); // off the button's tooltip
    expect_whole(window.look(), "from the front");
    // In the same place again; the device stands where it stood within a count.
    window.click("view/home");
    const ShownBox again = box_of(window.look().item("device and scene"));
    constexpr double kCount_px = 1.0;
    EXPECT_NEAR(again.left, home.left, kCount_px);
    EXPECT_NEAR(again.top, home.top, kCount_px);
    EXPECT_NEAR(again.bottom, home.bottom, kCount_px);
    // Panels.
    window.person().move_to(5.0F, static_cast<float>(home.bottom));
    expect_all_fits(settled(window), "as it opens");
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
    // Menus and sets of plots.
    const Point title = window.point_in("Servo", 0.5F, 0.02F); // nothing to click on
    window.click("plot 2/menu");
    expect_within_window(window, "Plots/plot 2/menu/");
    window.person().click(title.x, title.y);
    window.click("Plots/trigger");
    window.choose("Plots/trigger/source", "level");
    expect_within_window(window, "Plots/trigger/");
    window.person().click(title.x, title.y);
    window.click("Plots/sets");
    const Report open = window.look();
    const Point list = middle_of(open.item("Plots/sets"));
    int sets = 0;
    for (const auto &item : open.all().at("items")) {
        if (item.at("id").get<std::string>().starts_with("Plots/sets/")) {
            ++sets;
            const Point entry = middle_of(item); // the last one adds a plot
            window.person().click(entry.x, entry.y);
            window.person().move_to(1.0F, 1.0F);
            expect_plots_within_their_places(window.look(), item.at("text"));
            window.person().click(list.x, list.y);
        }
    }
    EXPECT_GE(sets, 8);
    window.person().click(title.x, title.y);
    while (expect_plots_within_their_places(window.look(), "ten") < 10) {
        window.choose("Plots/sets", "add a plot");
        window.person().move_to(1.0F, 1.0F);
    }
    // The legend, with a range; the smallest window has no room beside it.
    if (GetParam().width > 640) {
        window.click("legend/legend");
        window.click("legend/stiffness at the tip");
        window.click("legend/trace of 5 s");
        const Report shown = window.look();
        testing::expect_side_by_side(shown, "legend", "open");
        EXPECT_LT(box_of(shown.item("legend/stiffnesses")).bottom, box_of(shown.item("help")).top);
        for (const char *other : {"view/front", "lesson/put away"}) {
            const ShownBox box = box_of(shown.item(other));
            const ShownBox top = box_of(shown.item("legend/tip"));
            EXPECT_TRUE(box.bottom <= top.top || box.right <= top.left) << other;
        }
    }
}

TEST_P(Layout, ARecordFitsWithWhatOtherGainsWouldHaveDone) {
    ShownWindow window({"--open", folder_ / "touch.rec", "--kp", "7", "--scene",
                        testing::assets() / "scenes/plate.gltf"},
                       GetParam(), folder_);
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
}

INSTANTIATE_TEST_SUITE_P(Sizes, Layout,
                         ::testing::Values(testing::WindowSize{640, 400, 1.0},
                                           testing::WindowSize{1280, 720, 1.0},
                                           testing::WindowSize{2560, 1440, 2.0}),
                         [](const auto &size) { return std::to_string(size.param.width); });

} // namespace
} // namespace springdrive::app
