// Covers what the window remembers, and the first minute: app/panels/window_habits.cpp, the menu,
// the keys, the first minute's plate, and what is drawn, by its legend:
// app/panels/window_overlays.cpp.
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>

namespace springdrive::app {
namespace {

namespace fs = std::filesystem;

using testing::Report;
using testing::ShownWindow;

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

TEST(WindowHabits, DamagedSettingsAreSaidInOneLineAndKept) {
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
}

TEST(WindowHabits, ResetSettingsBeginsAnewAlsoWithADamagedFile) {
    const fs::path folder = testing::fresh_folder("habits_reset");
    std::ofstream(folder / "settings") << "damaged\n";
    ShownWindow window({"--settings", folder / "settings", "--reset-settings"});
    window.wait_until_running();
    EXPECT_TRUE(window.look().find("Start"));
    EXPECT_EQ(window.program().end(SIGTERM).exit_status, 0);
    EXPECT_EQ(window.program().error().find("damaged"), std::string::npos);
    EXPECT_FALSE(fs::exists(folder / "settings.damaged"));
}

} // namespace
} // namespace springdrive::app
