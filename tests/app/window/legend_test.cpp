// Covers app/panels/legend.cpp with what it switches: app/demo/shown_values.cpp,
// app/view/renderer.cpp.
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/shown_boxes.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <string>

namespace springdrive::app {
namespace {

using testing::Report;
using testing::ShownWindow;

/// How much is drawn as marks.
std::string marks_of(const Report &report) { return report.item("marks").at("text"); }

bool is_switched_on(const Report &report, const std::string &label) {
    return report.item("legend/" + label).at("value");
}

std::filesystem::path pressed_path(const std::filesystem::path &folder) {
    std::ofstream(folder / "down.csv") << "t,x,y,z\n0,0,0.06,0\n1.5,0,0.06,0\n2.2,0,-0.008,0\n";
    return folder / "down.csv";
}

TEST(LegendInTheWindow, EachSwitchAddsOrTakesAwayWhatItNames) {
    const std::filesystem::path folder = testing::fresh_folder("legend");
    ShownWindow window(
        {"--scene", testing::assets() / "scenes/plate.gltf", "--path", pressed_path(folder)});
    window.wait_until(
        [](const Report &report) {
            return report.column("touching") != 0.0 && report.column("time_s") > 4.0;
        },
        "the tip is pressed and at rest");
    window.click("legend/legend");
    for (const auto &[label, is_on] :
         std::initializer_list<std::pair<const char *, bool>>{{"tip", true},
                                                              {"height", true},
                                                              {"hand", true},
                                                              {"proxy", true},
                                                              {"normal", true},
                                                              {"force", true},
                                                              {"forces of both maps", false},
                                                              {"contact plane", false},
                                                              {"set-point", false},
                                                              {"stiffness at the tip", false},
                                                              {"trace of 5 s", false},
                                                              {"direction errors", false},
                                                              {"stiffnesses", false}}) {
        // A tip at rest leaves no trace.
        window.person().key("d");
        window.person().key("d");
        const Report before = window.look();
        EXPECT_EQ(is_switched_on(before, label), is_on) << label;
        window.click(std::string("legend/") + label);
        EXPECT_EQ(is_switched_on(window.look(), label), !is_on) << label;
        if (std::string(label) != "height") { // there is none on the surface
            EXPECT_NE(marks_of(window.look()), marks_of(before)) << label;
        }
        window.click(std::string("legend/") + label);
    }
    EXPECT_FALSE(window.look().shows("0 … ")); // ranges stand with what is on
    window.click("legend/stiffness at the tip");
    window.click("legend/direction errors");
    EXPECT_TRUE(window.look().shows(" N/mm"));
    EXPECT_TRUE(window.look().shows("0 … "));
    EXPECT_EQ(window.look().column("trip_cause"), 0.0);
    std::filesystem::remove_all(folder);
}

TEST(LegendInTheWindow, IsRememberedWithItsSwitches) {
    const std::filesystem::path folder = testing::fresh_folder("legend_remembered");
    {
        ShownWindow window({"--settings", folder / "settings"});
        window.click("legend/legend");
        window.click("legend/trace of 5 s");
        window.click("legend/normal");
    }
    const std::string written = testing::contents_of(folder / "settings");
    EXPECT_NE(written.find("opens_legend = true\n"), std::string::npos) << written;
    EXPECT_NE(
        written.find("drawn = [\"tip\", \"height\", \"hand\", \"proxy\", \"force\", \"trace\"]\n"),
        std::string::npos)
        << written;
    ShownWindow again({"--settings", folder / "settings"});
    EXPECT_TRUE(is_switched_on(again.look(), "trace of 5 s"));
    EXPECT_FALSE(is_switched_on(again.look(), "normal"));
    again.click("legend/fold");
    EXPECT_TRUE(again.look().find("legend/legend"));
    std::filesystem::remove_all(folder);
}

class OpenLegend : public ::testing::TestWithParam<testing::WindowSize> {};

TEST_P(OpenLegend, IsWholeAndBesideAllOtherPlates) {
    ShownWindow window({"--scene", testing::assets() / "scenes/wrong_direction.gltf"}, GetParam());
    window.wait_until_running();
    window.click("legend/legend");
    window.click("legend/stiffness at the tip"); // with its range
    window.click("legend/trace of 5 s");
    const Report report = window.look();
    testing::expect_side_by_side(report, "legend", "open");
    const auto &last = report.item("legend/stiffnesses");
    const double end = last.at("y").get<double>() + last.at("height").get<double>();
    EXPECT_LT(end, report.item("help").at("y").get<double>());
    for (const char *other : {"view/front", "lesson/put away"}) {
        const auto &item = report.item(other);
        const auto &first = report.item("legend/tip");
        EXPECT_TRUE(item.at("y").get<double>() + item.at("height").get<double>() <=
                        first.at("y").get<double>() ||
                    item.at("x").get<double>() + item.at("width").get<double>() <=
                        first.at("x").get<double>())
            << other;
    }
}

INSTANTIATE_TEST_SUITE_P(Sizes, OpenLegend,
                         ::testing::Values(testing::WindowSize{1280, 720, 1.0},
                                           testing::WindowSize{2560, 1440, 2.0}),
                         [](const auto &size) { return std::to_string(size.param.width); });

} // namespace
} // namespace springdrive::app
