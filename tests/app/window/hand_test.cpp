// Covers the simulated hand, its device and the scene that they are in, by mouse and keyboard:
// app/panels/{hand_tab,plant_tab,scene_card,legend,scene_overlay}.cpp and
// app/stage/{view_control,touch_by_click}.cpp.
#include "tests/support/devices.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

using testing::Report;
using testing::ShownWindow;

std::string scene_file(const std::string &name) {
    return testing::assets() / "scenes" / (name + ".gltf");
}

double force_N(const Report &report) {
    return std::hypot(report.column("force_x_N"), report.column("force_y_N"),
                      report.column("force_z_N"));
}

bool is_touching(const Report &report) { return report.column("touching") != 0.0; }

/// Where device and scene are in the picture.
struct Place {
    double left, top, right, bottom;
};

Place drawing_of(const Report &report) {
    const nlohmann::json &item = report.item("device and scene");
    const double left = item.at("x");
    const double top = item.at("y");
    return {left, top, left + item.at("width").get<double>(),
            top + item.at("height").get<double>()};
}

/// Moves the hand within the picture, and waits until the tip has followed, in free space.
/// @param by_px  to the right
void drag_tip(ShownWindow &window, testing::Point from, float by_px) {
    const double before_m = window.look().column("tip_x_m");
    window.person().drag(from, {from.x + by_px, from.y}, 0.3);
    window.wait_until(
        [&](const Report &report) { return std::abs(report.column("tip_x_m") - before_m) > 0.004; },
        "the hand follows", 5.0);
    EXPECT_FALSE(is_touching(window.look()));
}

TEST(HandInTheWindow, DragsMoveItBesideTheSceneAndAPressTouchesThereSlidesAndLiftsOff) {
    ShownWindow window({"--scene", scene_file("wrong_direction")});
    window.wait_until_running();
    // The scene is to be touched at the end of its caption's line.
    const nlohmann::json caption = window.look().item("press here");
    const testing::Point spot{
        caption.at("x").get<float>() + 0.5F * caption.at("width").get<float>(),
        caption.at("y").get<float>() + caption.at("height").get<float>() + 12.0F};
    drag_tip(window, {60.0F, 330.0F}, 30.0F); // on the floor
    window.person().press_key("Shift_L");
    drag_tip(window, spot, -30.0F); // back
    window.person().release_key("Shift_L");

    window.person().move_to(spot.x, spot.y);
    EXPECT_FALSE(is_touching(window.look()));
    window.person().press();
    const double pressed_s = window.look().column("time_s");
    const Report touched = window.wait_until(is_touching, "it touches", 5.0);
    EXPECT_LT(touched.column("time_s") - pressed_s, 2.0); // of the device's time
    // 6 mm of a hand of 300 N/m, in series with the coupling: 1.4 N against 1.2 N/mm. The structure
    // and friction take some.
    window.wait_until([](const Report &report) { return force_N(report) > 1.0; }, "it presses");
    window.let_pass(0.5);
    EXPECT_LT(force_N(window.look()), 2.0);
    // To the right, on the surface all the way.
    const double x_m = window.look().column("proxy_x_m");
    for (int step = 1; step <= 12; ++step) {
        window.person().move_to(spot.x + 3.0F * static_cast<float>(step), spot.y);
        const Report report = window.look();
        EXPECT_TRUE(is_touching(report)) << step;
        EXPECT_GT(force_N(report), 0.3) << step;
    }
    window.wait_until(
        [&](const Report &report) { return report.column("proxy_x_m") > x_m + 0.004; },
        "it has slid", 5.0);
    window.person().release();
    const Report free = window.wait_until(
        [](const Report &report) { return !is_touching(report) && force_N(report) < 0.3; },
        "it is lifted off", 5.0);
    EXPECT_EQ(free.column("trip_cause"), 0.0);
}

TEST(HandInTheWindow, NoPressAndNoSlideOnACurvedSurfaceStopsTheDevice) {
    ShownWindow window({"--scene", scene_file("organic")});
    window.wait_until_running();
    const Place drawing = drawing_of(window.look());
    const double middle = 0.5 * (drawing.left + drawing.right);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> share(-1.0F, 1.0F);
    int touched = 0;
    for (int press = 0; press < 8; ++press) {
        // Where the scene is, its edges, and the floor beside it.
        const testing::Point from{static_cast<float>(middle) + 120.0F * share(random),
                                  static_cast<float>(drawing.bottom) - 60.0F +
                                      50.0F * share(random)};
        window.person().move_to(from.x, from.y);
        window.person().press();
        window.let_pass(1.2);
        touched += is_touching(window.look()) ? 1 : 0;
        for (int step = 1; step <= 6; ++step) {
            window.person().move_to(from.x + 10.0F * static_cast<float>(step) * share(random),
                                    from.y + 8.0F * static_cast<float>(step) * share(random));
        }
        window.person().release();
    }
    EXPECT_EQ(window.look().column("trip_cause"), 0.0);
    EXPECT_GE(touched, 3);
}

struct Stiffness {
    double measured = 0.0;
    double predicted = 0.0;
};

/// Of "measured 1.80 ± 0.00 N/mm, predicted 1.78 N/mm".
Stiffness stiffness_shown(const Report &report) {
    for (const auto &item : report.all().at("items")) {
        std::istringstream text(item.at("text").get<std::string>());
        std::string word;
        Stiffness found;
        if (text >> word && word == "measured" && text >> found.measured) {
            while (text >> word && word != "predicted") {
            }
            text >> found.predicted;
            return found;
        }
    }
    return {};
}

TEST(HandInTheWindow, APressMeetsThePredictedStiffnessWithEitherMap) {
    const std::filesystem::path folder = testing::fresh_folder("press");
    std::ofstream(folder / "down.csv") << "t,x,y,z\n0,0,0.06,0\n1.5,0,0.06,0\n2,0,-0.012,0\n";
    // Without friction and structure, whose forces the servo does not know.
    ShownWindow window(
        {"--scene", scene_file("plate"), "--path", folder / "down.csv", "--without", "all"});
    window.wait_until([](const Report &report) { return report.column("time_s") > 3.0; },
                      "the tip touches");
    window.click("Scene/Hand");
    for (const char *map : {"transpose", "inverse"}) {
        window.click("Hand/play");
        window.wait_until(
            [](const Report &report) { return stiffness_shown(report).measured == 0.0; },
            "it plays");
        const Stiffness found = stiffness_shown(window.wait_until(
            [](const Report &report) { return stiffness_shown(report).measured > 0.0; },
            "it is measured"));
        // The press moves at up to 20 mm/s; 5 mm deep, J and with it the prediction change by some
        // percent; the shown digits end at 0.01 N/mm.
        EXPECT_NEAR(found.measured / found.predicted, 1.0, 0.05) << map;
        window.person().key("m");
    }
}

TEST(HandInTheWindow, TheViewFollowsAndZoomsAndTheHandFollowsKeysAScriptOrAFile) {
    const std::filesystem::path folder = testing::fresh_folder("window_paths");
    ShownWindow window({"--scene", scene_file("plate")}, {}, folder);
    window.wait_until_running();
    // The view has what the panels leave, until the camera is moved.
    const Place small = drawing_of(window.look());
    window.click("Plots/large");
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
    const Place before = drawing_of(window.look());
    EXPECT_NEAR(before.left, small.left, 1.0);
    // The wheel on the floor beside the device: what is there stays, so that the device moves away
    // from it.
    const auto x = static_cast<float>(before.left - 20.0);
    const auto y = static_cast<float>(before.bottom - 10.0);
    window.person().wheel(x, y, 3);
    const Place after = drawing_of(window.look());
    EXPECT_GT(after.left, before.left);
    EXPECT_LT(after.top, before.top);
    EXPECT_GT(after.right - after.left, 1.2 * (before.right - before.left));
    window.person().wheel(x, y, -3);
    EXPECT_NEAR(drawing_of(window.look()).left, before.left, 1.0);
    EXPECT_NEAR(drawing_of(window.look()).right, before.right, 1.0);
    // 10 mm up, 1 mm down; friction and weight hold the tip up to 0.7 mm from the hand's target.
    const double from_m = window.look().column("tip_y_m");
    for (int i = 0; i < 10; ++i) {
        window.person().key("e");
    }
    window.wait_until(
        [&](const Report &report) { return report.column("tip_y_m") > from_m + 5e-3; }, "up");
    for (int i = 0; i < 10; ++i) {
        window.person().key("shift+q");
    }
    window.wait_until(
        [&](const Report &report) {
            return std::abs(report.column("tip_y_m") - from_m - 9e-3) < 8e-4;
        },
        "a little down");
    // Paths.
    window.click("Scene/Hand");
    window.choose("Hand/grip", "firm hand");
    window.click("Hand/scripted touch");
    window.wait_until(is_touching, "it touches");
    window.click("Hand/stop the path");
    window.wait_until(
        [](const Report &report) { return report.find("Hand/scripted touch") != nullptr; },
        "it has stopped");
    std::ofstream(folder / "up.csv") << "t,x,y,z\n0,0,0.05,0\n1,0.02,0.05,0\n";
    window.enter("Hand/path", "up.csv");
    window.wait_until(
        [](const Report &report) {
            return report.find("Hand/path") != nullptr &&
                   std::abs(report.column("tip_x_m") - 0.02) < 2e-3 &&
                   std::abs(report.column("tip_y_m") - 0.05) < 2e-3;
        },
        "it is at the path's end");
    std::ofstream(folder / "bad.csv") << "t,x,y,z\n0,0,0.9,0\n";
    window.enter("Hand/path", "bad.csv");
    EXPECT_TRUE(window.look().shows("out of the device's reach")) << window.look().texts();
    window.enter("Hand/path", "none.csv");
    EXPECT_TRUE(window.look().shows("none.csv"));
    std::filesystem::remove_all(folder);
}

TEST(PlantInTheWindow, RateDelayEffectsAndDeviceChangeWhileItRunsAndTheDoctorNamesAMissingBoard) {
    ShownWindow window;
    EXPECT_TRUE(window.look().shows("PHANTOM 1.0, simulated"));
    window.wait_until_running();
    window.click("Scene/Plant");
    // The doctor is offered where no board is found on USB.
    window.click("Plant/device");
    if (window.look().find("Plant/device/doctor…") != nullptr) {
        const auto shows_answer = [](const Report &report) {
            return report.shows("disk for records in");
        };
        window.click("Plant/device/doctor…");
        const Report answer = window.wait_until(shows_answer, "the doctor's answer");
        EXPECT_TRUE(answer.shows("board on USB: none is connected")) << answer.texts();
        EXPECT_NE(answer.find("board on USB/copy"), nullptr) << answer.texts();
        window.person().key("Escape");
        window.wait_until([&](const Report &report) { return !shows_answer(report); }, "closed");
    } else {
        window.person().key("Escape");
    }
    window.enter("Plant/rate", "2000");
    window.wait_until([](const Report &report) { return report.column("since_last_s") == 5e-4; },
                      "twice as fast");
    window.enter("Plant/rate", "3");
    EXPECT_TRUE(window.look().shows("3")) << window.look().texts();
    EXPECT_EQ(window.look().column("since_last_s"), 5e-4);
    const testing::Point delay = window.point_in("Plant/delay");
    window.person().press_key("Control_L");
    window.person().click(delay.x, delay.y);
    window.person().release_key("Control_L");
    window.person().type("1.5");
    window.person().key("Return");
    EXPECT_EQ(window.look().item("Plant/delay").at("value"), 1.5);
    window.click("Plant/gravity");
    EXPECT_EQ(window.look().item("Plant/gravity").at("value"), false);
    EXPECT_EQ(window.look().item("Plant/motor tolerances").at("enabled"), false);
    EXPECT_EQ(window.look().column("trip_cause"), 0.0);
    window.choose("Plant/device", "simulated phantom_premium_1_5");
    window.wait_until(
        [](const Report &report) { return report.shows("PHANTOM Premium 1.5, simulated"); },
        "the other device is used");
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
    ShownWindow window({"--scene", scene_file("wrong_direction"), "--path", folder / "press.csv",
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
    ShownWindow window({"--scene", scene_file("plate")}, {}, folder);
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
        window.wait_until([&sought = title](const Report &report) { return report.shows(sought); },
                          title);
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
    ShownWindow window({"--scene", scene_file("plate"), "--path", folder / "down.csv"});
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
    const std::vector<std::string> on{"tip", "height", "hand", "proxy", "normal", "force"};
    std::vector<std::string> all = on;
    all.insert(all.end(),
               {"forces of both maps", "contact plane", "set-point", "stiffness at the tip",
                "trace of 5 s", "direction errors", "stiffnesses"});
    for (const std::string &label : all) {
        const bool is_on = std::ranges::count(on, label) > 0;
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
    ShownWindow window({"--scene", scene_file("plate"), "--path", folder / "held.csv"});
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
    ShownWindow window({"--scene", scene_file("plate"), "--path", folder / "down.csv"});
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
