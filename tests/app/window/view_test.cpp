// Covers app/stage/view_control.cpp: what is in the picture, by mouse and keyboard.
#include "tests/support/devices.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

using testing::Report;
using testing::ShownWindow;

struct Place {
    double left, top, right, bottom;
};

Place place_of(const nlohmann::json &item) {
    const double left = item.at("x");
    const double top = item.at("y");
    return {left, top, left + item.at("width").get<double>(),
            top + item.at("height").get<double>()};
}

Place drawing_of(const Report &report) { return place_of(report.item("device and scene")); }

bool overlap(const Place &a, const Place &b) {
    return std::min(a.right, b.right) > std::max(a.left, b.left) &&
           std::min(a.bottom, b.bottom) > std::max(a.top, b.top);
}

/// Within the window, and nothing is drawn over it.
void expect_whole(const Report &report, const std::string &when) {
    const Place drawing = drawing_of(report);
    EXPECT_GT(drawing.left, 0.0) << when;
    EXPECT_GT(drawing.top, 0.0) << when;
    int others = 0;
    for (const auto &item : report.all().at("items")) {
        const std::string kind = item.at("kind");
        if (kind == "drawing" || kind == "tooltip") {
            continue;
        }
        ++others;
        EXPECT_FALSE(overlap(drawing, place_of(item))) << when << ": " << item.dump();
    }
    EXPECT_GT(others, 20) << when;
}

class View : public ::testing::TestWithParam<testing::WindowSize> {};

TEST_P(View, ShowsTheWholeDeviceAtTheStartFromAboveAndFromTheFront) {
    ShownWindow window({"--scene", testing::assets() / "scenes/stepped_block.gltf"}, GetParam());
    window.wait_until_running();
    const Report first = window.look();
    expect_whole(first, "at the start");
    const Place home = drawing_of(first);
    window.person().key("t");
    expect_whole(window.look(), "from above");
    window.click("view/front");
    window.person().move_to(5.0F, static_cast<float>(home.bottom)); // off the button's tooltip
    expect_whole(window.look(), "from the front");
    // In the same place again; the device stands where it stood within a count.
    window.click("view/home");
    const Place again = drawing_of(window.look());
    constexpr double kCount_px = 1.0;
    EXPECT_NEAR(again.left, home.left, kCount_px);
    EXPECT_NEAR(again.top, home.top, kCount_px);
    EXPECT_NEAR(again.bottom, home.bottom, kCount_px);
}

INSTANTIATE_TEST_SUITE_P(Sizes, View,
                         ::testing::Values(testing::WindowSize{640, 400, 1.0},
                                           testing::WindowSize{1280, 720, 1.0},
                                           testing::WindowSize{2560, 1440, 2.0}),
                         [](const auto &size) { return std::to_string(size.param.width); });

TEST(ViewInTheWindow, FollowsTheSpaceForItUntilTheCameraIsMoved) {
    ShownWindow window({"--scene", testing::assets() / "scenes/plate.gltf"});
    window.wait_until_running();
    const Place small = drawing_of(window.look());
    window.click("Plots/large"); // the scene gets what is left
    const Place smaller = drawing_of(window.look());
    EXPECT_LT(smaller.bottom - smaller.top, 0.8 * (small.bottom - small.top));
    window.click("Plots/large");
    EXPECT_NEAR(drawing_of(window.look()).top, small.top, 1.0);
    window.person().key("l"); // turned by the person: it stays so
    const Place turned = drawing_of(window.look());
    window.click("Plots/large");
    window.click("Plots/large");
    EXPECT_NEAR(drawing_of(window.look()).left, turned.left, 1.0);
    window.person().key("Home");
    EXPECT_NEAR(drawing_of(window.look()).left, small.left, 1.0);
}

TEST(ViewInTheWindow, TheWheelZoomsToWhatIsUnderTheCursor) {
    ShownWindow window({"--scene", testing::assets() / "scenes/plate.gltf"});
    window.wait_until_running();
    const Place before = drawing_of(window.look());
    // On the floor beside the device: what is there stays, so that the device moves away from it.
    const auto x = static_cast<float>(before.left - 20.0);
    const auto y = static_cast<float>(before.bottom - 10.0);
    window.person().wheel(x, y, 3);
    const Place after = drawing_of(window.look());
    EXPECT_GT(after.left, before.left);
    EXPECT_LT(after.top, before.top);
    EXPECT_GT(after.right - after.left, 1.2 * (before.right - before.left));
    window.person().wheel(x, y, -3);
    const Place back = drawing_of(window.look());
    EXPECT_NEAR(back.left, before.left, 1.0);
    EXPECT_NEAR(back.right, before.right, 1.0);
}

} // namespace
} // namespace springdrive::app
