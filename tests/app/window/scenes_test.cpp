// Covers app/panels/scene_card.cpp: what a scene says that there is to feel.
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

using testing::Report;
using testing::ShownWindow;

std::string scene_of(const std::string &name) {
    return testing::assets() / "scenes" / (name + ".gltf");
}

/// The angle that the plate shows for a map; −1 if none.
double shown_deg(const Report &report, const std::string &map) {
    const auto *const item = report.find("lesson/" + map);
    const std::string text = item != nullptr ? item->at("text").get<std::string>() : std::string();
    return text.find("°") == std::string::npos ? -1.0 : std::stod(text);
}

TEST(SceneInTheWindow, OneKeyShowsTheWrongDirectionAndTheRightOne) {
    const std::filesystem::path folder = testing::fresh_folder("wrong_direction");
    std::ofstream(folder / "press.csv") // on the scene's spot, 6 mm deep
        << "t,x,y,z\n0,0,0,0\n1.2,0,0,0\n2,0,-0.030,0.040\n2.6,0,-0.0468,0.0337\n";
    ShownWindow window({"--scene", scene_of("wrong_direction"), "--path", folder / "press.csv",
                        "--map", "inverse"});
    EXPECT_TRUE(window.look().shows("The wrong direction"));
    EXPECT_EQ(shown_deg(window.look(), "inverse"), -1.0);
    window.wait_until([](const Report &report) { return shown_deg(report, "inverse") > 25.0; },
                      "the inverse map's push is far off");
    EXPECT_EQ(shown_deg(window.look(), "transpose"), -1.0);
    window.person().key("m");
    window.wait_until(
        [](const Report &report) {
            const double deg = shown_deg(report, "transpose");
            return deg >= 0.0 && deg < 5.0;
        },
        "the transpose map's is not");
    EXPECT_GT(shown_deg(window.look(), "inverse"), 25.0); // stays, to be compared
    window.click("lesson/other map");
    window.wait_until(
        [](const Report &report) { return report.column("rendered_error_rad") > 0.44; },
        "back with the button"); // 25°
}

TEST(SceneInTheWindow, TheSentenceCanBePutAwayAndBroughtBack) {
    ShownWindow window({"--scene", scene_of("plate")});
    EXPECT_TRUE(window.look().shows("Press on it"));
    window.click("lesson/put away");
    EXPECT_FALSE(window.look().shows("Press on it"));
    window.click("Scene/what to feel");
    EXPECT_TRUE(window.look().shows("Press on it"));
    window.click("lesson/put away");
    window.choose("Scene/files", "slope.gltf"); // another scene has something new to say
    window.wait_until([](const Report &report) { return report.shows("A slope without friction"); },
                      "the other scene's sentence");
}

TEST(SceneInTheWindow, GoesFromSceneToScene) {
    ShownWindow window({"--scene", scene_of("slope")});
    window.wait_until_running(); // until then a message takes room
    window.click("lesson/next"); // in the order of the tour
    const Report next = window.wait_until(
        [](const Report &report) { return report.shows("From hard to soft"); }, "the next scene");
    EXPECT_TRUE(next.shows("η 0.75")); // on its pad
    const auto goes_to = [&](const char *button, const char *title) {
        window.click(button);
        window.wait_until([&](const Report &report) { return report.shows(title); }, title);
    };
    goes_to("lesson/previous", "A slope without friction");
    goes_to("lesson/previous", "The wrong direction");
    goes_to("lesson/previous", "A stiff wall");
    goes_to("lesson/previous", "A blow"); // the last is before the first
    goes_to("lesson/next", "A stiff wall");
}

TEST(SceneInTheWindow, AModelOfOnesOwnHasNoPlate) {
    const std::filesystem::path folder = testing::fresh_folder("own_model");
    std::ofstream(folder / "own.gltf")
        << R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{)"
        << R"("attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,)"
        << R"("count":3,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[)"
        << R"({"byteLength":36,"uri":"data:;base64,)" // (0, 0, 0), (1, 0, 0), (0, 1, 0)
        << R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
    ShownWindow window({"--scene", folder / "own.gltf"});
    EXPECT_TRUE(window.look().shows("own.gltf"));
    EXPECT_EQ(window.look().find("lesson/put away"), nullptr);
}

} // namespace
} // namespace springdrive::app
