// Covers what the window keeps: records and sessions, app/panels/{record_tab,session_keeper}.cpp;
// what it remembers, and the first minute: app/panels/window_habits.cpp, the menu, the keys, and
// what is drawn in app/panels/{window_overlays,legend}.cpp.
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/program.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>

namespace springdrive::app {
namespace {

using testing::Report;
using testing::run_program;
using testing::ShownWindow;

double position_s(const Report &report) { return report.item("record/position").at("value"); }

bool shows_record(const Report &report) { return report.find("record/position") != nullptr; }

/// The only folder of a run in `folder`; empty if there is none.
std::filesystem::path run_in(const std::filesystem::path &folder) {
    std::filesystem::path found;
    for (const auto &entry : std::filesystem::directory_iterator(folder)) {
        if (std::filesystem::exists(entry.path() / "run.json")) {
            EXPECT_TRUE(found.empty());
            found = entry.path();
        }
    }
    return found;
}

class RecordsInTheWindow : public ::testing::Test {
protected:
    /// Of a drawn device that touches a sphere.
    static void SetUpTestSuite() {
        folder_ = testing::fresh_folder("window_records");
        const testing::Ending ending = run_program(
            {"record", folder_ / "touch.rec", "--lockstep", "--seconds", "6", "--device-seed", "7",
             "--scene", testing::assets() / "scenes/sphere.gltf"});
        ASSERT_EQ(ending.exit_status, 0) << ending.error;
    }

    inline static std::filesystem::path folder_;
};

TEST_F(RecordsInTheWindow, OtherGainsAreComputedForTheSameMotion) {
    ShownWindow window({"--scene", testing::assets() / "scenes/plate.gltf", "--open", "touch.rec"},
                       {}, folder_);
    window.wait_until(shows_record, "the record is shown");
    EXPECT_TRUE(window.look().shows("Not its scene: it was recorded on 'sphere.gltf'"));
    window.click("Scene/Record");
    window.click("Record/what if: the active tuning");
    EXPECT_TRUE(window.look().shows("it is that of the record"));
    window.enter("Gains/dR_Ohm/typed", "0.25");
    window.person().move_to(100.0F, 300.0F);
    // Past the first seconds, where the tip touches.
    const testing::Point at = window.point_in("record/position", 0.75F, 0.5F);
    window.person().click(at.x, at.y);
    const auto forces_N = [](const Report &report) {
        std::vector<double> force_N;
        for (const auto &item : report.all().at("items")) {
            if (item.at("id") == "Scene/Record/force") {
                force_N.push_back(std::stod(item.at("text").get<std::string>()));
            }
        }
        return force_N;
    };
    const std::vector<double> force_N = forces_N(window.wait_until(
        [&](const Report &report) {
            return forces_N(report).size() == 2 && !report.shows("tuning before it");
        },
        "the answer for other gains"));
    // A record of 1 N or so, with dR of 0.5 Ω; half of that pulls about twice as much for the same
    // depth (13), friction and back-EMF apart.
    EXPECT_GT(force_N[0], 0.3);
    EXPECT_GT(force_N[1], 1.4 * force_N[0]);
    EXPECT_LT(force_N[1], 2.6 * force_N[0]);
    window.click("Record/load its tuning");
    EXPECT_EQ(window.look().item("Gains/dR_Ohm/typed").at("value"), 0.5);
}

TEST_F(RecordsInTheWindow, ARecordIsPlayedSteppedAndLeftAndWhatIsNoneIsRefused) {
    const std::filesystem::path folder = testing::fresh_folder("window_played");
    std::filesystem::copy(folder_ / "touch.rec", folder);
    std::ofstream(folder / "text.rec") << "this is no record";
    std::ofstream(folder / "up.csv") << "t,x,y,z\n0,0,0.05,0\n1,0.02,0.05,0\n";
    ShownWindow window({"--scene", testing::assets() / "scenes/sphere.gltf"}, {}, folder);
    window.wait_until_running();
    window.click("Scene/Record");
    for (const std::string name : {"text.rec", "nothing"}) {
        window.enter("Record/path", name);
        window.wait_until([&](const Report &report) { return report.shows(name + ": "); },
                          "refused");
        EXPECT_FALSE(shows_record(window.look()));
    }
    testing::expect_refused(run_program({"demo", "--open", folder / "nothing.rec"}),
                            "nothing.rec: not found");
    window.choose("Record/files", "touch.rec");
    window.wait_until(shows_record, "the record is shown");
    EXPECT_TRUE(window.look().shows("Record: touch.rec"));
    EXPECT_FALSE(window.look().shows("Not its scene"));
    EXPECT_NEAR(position_s(window.look()), 0.0, 1e-3);
    // In the plots time ends where the record stands.
    window.person().key("period");
    window.person().key("period");
    window.person().key("comma");
    EXPECT_NEAR(position_s(window.look()), 1e-3, 1e-6);
    window.person().key("p");
    const double tick = window.look().column("tick");
    const Report played = window.wait_until(
        [](const Report &report) { return position_s(report) > 1.0; }, "it plays");
    window.person().key("p");
    const double stands_s = position_s(window.look());
    EXPECT_EQ(position_s(window.look()), stands_s);
    EXPECT_NEAR(window.look().item("plot 1/area").at("numbers").at("x_to"), stands_s, 1e-9);
    // The servo went on, and the mouse moved no hand that is not shown.
    EXPECT_GT(played.column("tick"), tick + 500.0);
    window.person().key("r");
    EXPECT_FALSE(shows_record(window.look()));
    EXPECT_EQ(window.look().item("plot 1/area").at("numbers").at("x_to"), 0.0);
    window.person().key("r");
    EXPECT_EQ(position_s(window.look()), stands_s);
    window.click("Record/close");
    EXPECT_FALSE(shows_record(window.look()));

    // Files are dropped by their kind.
    window.person().drop_files(200.0F, 200.0F, {folder / "up.csv"});
    window.wait_until(
        [](const Report &report) { return std::abs(report.column("tip_x_m") - 0.02) < 2e-3; },
        "the hand follows the path");
    window.person().drop_files(200.0F, 200.0F, {folder / "touch.rec"});
    window.wait_until(shows_record, "the record is shown");
    window.person().key("r");
    window.click("Scene/Scene");
    window.person().drop_files(200.0F, 200.0F, {testing::assets() / "scenes/plate.gltf"});
    window.wait_until([](const Report &report) { return report.shows("plate.gltf"); },
                      "the scene is shown");
    std::filesystem::remove_all(folder); // where it was started
    window.person().key("ctrl+s");
    window.wait_until([](const Report &report) { return report.shows("springdrive-"); },
                      "why it cannot be kept");
    EXPECT_EQ(window.look().find("Servo/kept"), nullptr);
    EXPECT_EQ(window.look().column("trip_cause"), 0.0);
}

TEST(KeepingInTheWindow, AKeptSessionIsReplayedTomorrow) {
    const std::filesystem::path folder = testing::fresh_folder("window_kept");
    std::ofstream(folder / "down.csv") << "t,x,y,z\n0,0,0.06,0\n1.5,0,0.06,0\n2,0,-0.012,0\n";
    {
        ShownWindow window({"--scene", testing::assets() / "scenes/plate.gltf", "--path",
                            folder / "down.csv", "--device-seed", "7"},
                           {}, folder);
        window.wait_until([](const Report &report) { return report.column("time_s") > 3.0; },
                          "the tip touches");
        window.enter("Gains/dR_Ohm/typed", "0.4");
        window.let_pass(0.5); // the change is over
        window.click("Servo/Notes");
        window.click("Notes/notes");
        window.person().type("softer than steel");
        window.person().key("ctrl+s"); // while typing
        window.wait_until([](const Report &report) { return report.find("Servo/kept") != nullptr; },
                          "kept");
        EXPECT_EQ(window.look().column("trip_cause"), 0.0); // no space stopped it
        const double kept_s = window.look().column("time_s");
        window.wait_until(
            [&](const Report &report) { return report.column("time_s") > kept_s + 1.0; },
            "it goes on");
        EXPECT_EQ(window.program().end(SIGTERM).exit_status, 0);
    }
    const std::filesystem::path run = run_in(folder);
    ASSERT_FALSE(run.empty());
    EXPECT_EQ(testing::contents_of(run / "notes.txt"), "softer than steel");
    EXPECT_TRUE(std::filesystem::exists(run / "screenshot-1.png"));
    const testing::Ending replayed = run_program({"replay", run});
    EXPECT_EQ(replayed.exit_status, 0) << replayed.out << replayed.error;
    EXPECT_NE(replayed.out.find("2 of 2 records"), std::string::npos) << replayed.out;
    EXPECT_EQ(replayed.out.find("differs"), std::string::npos) << replayed.out;

    ShownWindow tomorrow({"--scene", testing::assets() / "scenes/plate.gltf", "--open", run}, {},
                         folder);
    tomorrow.wait_until(shows_record, "the record is shown");
    tomorrow.click("Scene/Record");
    EXPECT_TRUE(tomorrow.look().shows("softer than steel"));
    tomorrow.choose("Record/part", "record.rec");
    tomorrow.wait_until([](const Report &report) { return report.shows("Record: record.rec"); },
                        "the other part");
    tomorrow.click("Record/load its tuning");
    EXPECT_EQ(tomorrow.look().item("Gains/dR_Ohm/typed").at("value"), 0.4);
    std::filesystem::remove_all(folder);
}

namespace fs = std::filesystem;

double scale_of(const Report &report) { return report.all().at("window").at("scale"); }

bool is_switched_on(const Report &report, const std::string &label) {
    return report.item("legend/" + label).at("value");
}

constexpr testing::WindowSize kOwnSize{1280, 720, 1.0, false};

TEST(WindowHabits, TheFirstMinuteIsDismissedForGoodAndTheLegendRemembered) {
    const fs::path folder = testing::fresh_folder("first_minute");
    {
        ShownWindow window({"--settings", folder / "settings"});
        window.wait_until_running();
        const Report report = window.look();
        EXPECT_TRUE(report.shows("No device is attached"));
        EXPECT_TRUE(report.shows("press where it is to touch"));
        EXPECT_TRUE(report.shows("press on the surface"));
        // Between the scene and the plots: it hides neither.
        const double top = report.item("Start").at("y");
        const double height = report.item("Start").at("height");
        EXPECT_NEAR(top + height, report.item("Plots").at("y").get<double>(), 1.0);
        window.click("Start/keys  F1");
        EXPECT_TRUE(window.look().shows("emergency stop, at any time"));
        window.person().key("Escape");
        window.click("Start/got it");
        EXPECT_FALSE(window.look().find("Start"));
        EXPECT_TRUE(window.look().shows("left press on the scene: touch there"));
        window.click("legend/legend");
        window.click("legend/trace of 5 s");
        window.click("legend/normal");
    }
    const std::string written = testing::contents_of(folder / "settings");
    for (const char *line :
         {"dismissed_start = true\n", "opens_legend = true\n",
          "drawn = [\"tip\", \"height\", \"hand\", \"proxy\", \"force\", \"trace\"]\n"}) {
        EXPECT_NE(written.find(line), std::string::npos) << line << " in " << written;
    }
    ShownWindow again({"--settings", folder / "settings"});
    again.wait_until_running();
    EXPECT_FALSE(again.look().find("Start"));
    EXPECT_TRUE(is_switched_on(again.look(), "trace of 5 s"));
    EXPECT_FALSE(is_switched_on(again.look(), "normal"));
    again.click("legend/fold");
    EXPECT_TRUE(again.look().find("legend/legend"));
    again.click("window/menu");
    again.click("reset the settings");
    again.wait_until([](const Report &report) { return report.find("Start") != nullptr; },
                     "the plate is there again");
    EXPECT_FALSE(fs::exists(folder / "settings"));
}

TEST(WindowHabits, KeysHidePanelsAndChangeTheTextWhichIsRemembered) {
    const fs::path folder = testing::fresh_folder("habits");
    const fs::path settings = folder / "settings";
    std::ofstream(settings) << "text_size = 1.0\nwidth = 1100\nheight = 700\n"
                               "dismissed_start = true\n";
    {
        ShownWindow window({"--settings", settings}, kOwnSize);
        window.wait_until_running();
        const Report first = window.look();
        EXPECT_EQ(first.all().at("window").at("width"), 1100);
        EXPECT_EQ(first.all().at("window").at("height"), 700);
        EXPECT_EQ(scale_of(first), 1.0);
        window.person().key("F10");
        const Report bare = window.look();
        for (const char *panel : {"Tuning", "Servo", "Scene", "Plots"}) {
            EXPECT_FALSE(bare.find(panel)) << panel;
        }
        EXPECT_TRUE(bare.find("stop/STOP  F12"));
        EXPECT_TRUE(bare.find("read-outs/force"));
        window.person().key("ctrl+equal");
        EXPECT_NEAR(scale_of(window.look()), 1.25, 1e-6);
        EXPECT_TRUE(window.look().shows("text at 125 %"));
        window.person().key("ctrl+equal");
        EXPECT_EQ(window.program().end(SIGTERM).exit_status, 0);
    }
    const std::string kept = testing::contents_of(settings);
    EXPECT_NE(kept.find("text_size = 1.5\nhides_panels = true\n"), std::string::npos) << kept;
    EXPECT_NE(kept.find("width = 1100\nheight = 700\n"), std::string::npos) << kept;
    ShownWindow again({"--settings", settings}, kOwnSize);
    again.wait_until([](const Report &report) { return report.find("read-outs/force") != nullptr; },
                     "without panels");
    EXPECT_NEAR(scale_of(again.look()), 1.5, 1e-6);
    again.person().key("ctrl+minus");
    EXPECT_NEAR(scale_of(again.look()), 1.25, 1e-6);
    again.person().key("ctrl+0");
    EXPECT_NEAR(scale_of(again.look()), 1.0, 1e-6);
    again.person().key("F10");
    EXPECT_TRUE(again.look().find("Tuning"));
}

TEST(WindowHabits, PicturesAndRecentFilesAreOfferedAndTextGrowsNoFurtherThanPanelsAllow) {
    const fs::path folder = testing::fresh_folder("habits_recent");
    const fs::path own = testing::fresh_folder("habits_picture");
    const fs::path scene = folder / "my own scene.gltf";
    fs::copy_file(testing::assets() / "scenes/plate.gltf", scene);
    ShownWindow window({"--settings", folder / "settings"}, {}, own);
    window.wait_until_running();
    window.person().key("ctrl+equal");
    const double largest = scale_of(window.look());
    EXPECT_GT(largest, 1.0);
    window.person().key("ctrl+equal");
    EXPECT_TRUE(window.look().shows("no larger text fits"));
    EXPECT_EQ(scale_of(window.look()), largest);
    window.person().key("ctrl+0");
    EXPECT_EQ(scale_of(window.look()), 1.0);

    window.enter("Scene/path", scene);
    const auto shows_it = [](const Report &report) {
        return report.item("Scene/files").at("text") == "my own scene.gltf";
    };
    window.wait_until(shows_it, "it is shown");
    EXPECT_NE(
        testing::contents_of(folder / "settings").find("recent = [\"" + scene.string() + "\"]\n"),
        std::string::npos);
    window.enter("Scene/path", testing::assets() / "scenes/profile.gltf");
    window.wait_until([&](const Report &report) { return !shows_it(report); }, "another one");
    window.click("window/menu");
    EXPECT_TRUE(window.look().find("my own scene.gltf"));
    EXPECT_FALSE(window.look().find("profile.gltf")); // included scenes are in their own list
    window.click("my own scene.gltf");
    window.wait_until(shows_it, "it is shown again");
    fs::remove(scene);
    window.click("window/menu");
    EXPECT_FALSE(window.look().item("my own scene.gltf").value("enabled", true));
    window.person().key("Escape");

    window.person().key("F9");
    window.wait_until([](const Report &report) { return report.shows("picture: springdrive-"); },
                      "it says where");
    const auto picture = std::ranges::find_if(
        fs::directory_iterator(own), fs::directory_iterator(),
        [](const fs::directory_entry &entry) { return entry.path().extension() == ".png"; });
    ASSERT_NE(picture, fs::directory_iterator());
    // Width and height follow the names of the file and of its first chunk.
    EXPECT_EQ(testing::contents_of(picture->path()).substr(16, 8),
              std::string("\0\0\x05\0\0\0\x02\xd0", 8)); // 1280, 720
    fs::remove_all(own);
    window.person().key("F9");
    window.wait_until([](const Report &report) { return report.shows("cannot be"); },
                      "it says why not");
}

TEST(WindowHabits, DamagedSettingsAreSaidInOneLineAndKeptUnlessTheyAreReset) {
    const fs::path folder = testing::fresh_folder("habits_damaged");
    std::ofstream(folder / "settings") << "\ntext_size = \"huge\"\n";
    ShownWindow window({"--settings", folder / "settings"});
    window.wait_until_running();
    EXPECT_TRUE(window.look().shows("settings:2: text_size is 'huge'; it must be a number"));
    window.click("Start/got it"); // the defaults
    EXPECT_EQ(window.program().end(SIGTERM).exit_status, 0);
    const std::string error = window.program().error();
    EXPECT_NE(error.find("settings:2: text_size"), std::string::npos) << error;
    EXPECT_NE(testing::contents_of(folder / "settings").find("dismissed_start = true"),
              std::string::npos);
    EXPECT_NE(testing::contents_of(folder / "settings.damaged").find("= \"huge\""),
              std::string::npos);
    fs::remove(folder / "settings.damaged");
    std::ofstream(folder / "settings") << "damaged\n";
    ShownWindow anew({"--settings", folder / "settings", "--reset-settings"});
    anew.wait_until_running();
    EXPECT_TRUE(anew.look().find("Start"));
    EXPECT_EQ(anew.program().end(SIGTERM).exit_status, 0);
    EXPECT_EQ(anew.program().error().find("damaged"), std::string::npos);
    EXPECT_FALSE(fs::exists(folder / "settings.damaged"));
}

} // namespace
} // namespace springdrive::app
