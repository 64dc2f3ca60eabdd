// Covers what a scene says that there is to feel, what is drawn in it, and the messages over it:
// app/panels/scene_card.cpp, app/panels/window_overlays.cpp, app/panels/scene_overlay.cpp.
#include "tests/support/devices.h"
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

TEST(SceneInTheWindow, TheSentenceIsPutAwayAndTheTourGoesFromSceneToScene) {
    const std::filesystem::path folder = testing::fresh_folder("own_model");
    std::ofstream(folder / "own.gltf")
        << R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{)"
        << R"("attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,)"
        << R"("count":3,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[)"
        << R"({"byteLength":36,"uri":"data:;base64,)" // (0, 0, 0), (1, 0, 0), (0, 1, 0)
        << R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
    ShownWindow window({"--scene", scene_of("plate")}, {}, folder);
    EXPECT_TRUE(window.look().shows("Press on it"));
    window.click("lesson/put away");
    EXPECT_FALSE(window.look().shows("Press on it"));
    window.click("Scene/what to feel");
    EXPECT_TRUE(window.look().shows("Press on it"));
    window.click("lesson/put away");
    window.choose("Scene/files", "slope.gltf"); // another scene has something new to say
    window.wait_until([](const Report &report) { return report.shows("A slope without friction"); },
                      "the other scene's sentence");
    window.wait_until_running(); // until then a message takes room
    window.click("lesson/next"); // in the order of the tour
    const Report next = window.wait_until(
        [](const Report &report) { return report.shows("From hard to soft"); }, "the next scene");
    EXPECT_TRUE(next.shows("η 0.75")); // on its pad
    for (const auto &[button, title] : {std::pair{"previous", "A slope without friction"},
                                        {"previous", "The wrong direction"},
                                        {"previous", "A stiff wall"},
                                        {"previous", "A blow"}, // the last is before the first
                                        {"next", "A stiff wall"}}) {
        window.click(std::string("lesson/") + button);
        window.wait_until([&](const Report &report) { return report.shows(title); }, title);
    }
    window.enter("Scene/path", "own.gltf"); // a model of one's own has no plate
    window.wait_until(
        [](const Report &report) { return report.find("lesson/put away") == nullptr; }, "no plate");
    EXPECT_TRUE(window.look().shows("own.gltf"));
    std::filesystem::remove_all(folder);
}

TEST(LegendInTheWindow, EachSwitchAddsOrTakesAwayWhatItNames) {
    const std::filesystem::path folder = testing::fresh_folder("legend");
    std::ofstream(folder / "down.csv") << "t,x,y,z\n0,0,0.06,0\n1.5,0,0.06,0\n2.2,0,-0.008,0\n";
    ShownWindow window({"--scene", scene_of("plate"), "--path", folder / "down.csv"});
    window.wait_until(
        [](const Report &report) {
            return report.column("touching") != 0.0 && report.column("time_s") > 4.0;
        },
        "the tip is pressed and at rest");
    window.click("legend/legend");
    const auto switched_on = [](const Report &report, const std::string &label) -> bool {
        return report.item("legend/" + label).at("value");
    };
    // How much is drawn as marks.
    const auto marks = [](const Report &report) -> std::string {
        return report.item("marks").at("text");
    };
    for (const auto &[label, is_on] :
         std::initializer_list<std::pair<std::string, bool>>{{"tip", true},
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
        EXPECT_EQ(switched_on(before, label), is_on) << label;
        window.click("legend/" + label);
        EXPECT_EQ(switched_on(window.look(), label), !is_on) << label;
        if (label != "height") { // there is none on the surface
            EXPECT_NE(marks(window.look()), marks(before)) << label;
        }
        window.click("legend/" + label);
    }
    EXPECT_FALSE(window.look().shows("0 … ")); // ranges stand with what is on
    window.click("legend/stiffness at the tip");
    window.click("legend/direction errors");
    EXPECT_TRUE(window.look().shows(" N/mm"));
    EXPECT_TRUE(window.look().shows("0 … "));
    EXPECT_EQ(window.look().column("trip_cause"), 0.0);
    std::filesystem::remove_all(folder);
}

TEST(SceneMessagesInTheWindow, ATipThatStartsInsideIsPulledOutByTheButton) {
    const std::filesystem::path folder = testing::fresh_folder("starts_inside");
    // The hand holds still there, and can be moved after a moment.
    std::ofstream(folder / "held.csv") << "t,x,y,z\n0,0,-0.009,0\n0.2,0,-0.009,0\n";
    ShownWindow window({"--scene", scene_of("plate"), "--path", folder / "held.csv"});
    window.wait_until(
        [](const Report &report) { return report.find("inside/pull it out") != nullptr; },
        "the tip is inside");
    EXPECT_TRUE(window.look().shows("The tip is inside: pull out."));
    const double before_m = window.look().column("tip_y_m");
    window.click("inside/pull it out");
    const Report out = window.wait_until(
        [](const Report &report) { return report.find("inside") == nullptr; }, "it is out");
    EXPECT_GT(out.column("tip_y_m"), before_m);
    EXPECT_EQ(out.column("trip_cause"), 0.0);
    window.wait_until_running();
    EXPECT_FALSE(window.look().shows("inside"));
}

TEST(SceneMessagesInTheWindow, AResetInContactSaysWhatIsMissingAndAButtonLiftsTheTip) {
    const std::filesystem::path folder = testing::fresh_folder("lifted");
    // Down into the plate, where it stays until the path's end, and a second longer.
    std::ofstream(folder / "down.csv") << "t,x,y,z\n0,0,0.06,0\n1.5,0,0.06,0\n2.5,0,-0.01,0\n";
    ShownWindow window({"--scene", scene_of("plate"), "--path", folder / "down.csv"});
    window.wait_until([](const Report &report) { return report.column("touching") != 0.0; },
                      "the tip touches");
    window.person().key("F12");
    window.click("stopped/Reset");
    window.wait_until(
        [](const Report &report) {
            return report.find("waiting") && report.shows("until the tip is lifted off");
        },
        "the window says that the tip must be lifted");
    window.wait_until(
        [](const Report &report) { return report.find("waiting/lift the tip") != nullptr; },
        "the path is over, and the button is there");
    EXPECT_TRUE(window.look().shows("Lift the tip to start."));
    window.click("waiting/lift the tip");
    window.wait_until_running();
    EXPECT_EQ(window.look().column("touching"), 0.0);
}

} // namespace
} // namespace springdrive::app
