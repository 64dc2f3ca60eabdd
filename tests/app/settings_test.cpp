// Covers app/panels/window_habits.cpp: what the window remembers, and files that are damaged or
// cannot be written.
#include "app/panels/window_habits.h"

#include "base/input_error.h"
#include "tests/support/error_text.h"
#include "tests/support/files.h"
#include "tests/support/full_disk.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

namespace fs = std::filesystem;

class WindowSettings : public ::testing::Test {
protected:
    void write(const std::string &text) const { std::ofstream(file, std::ios::binary) << text; }

    fs::path folder = testing::fresh_folder("settings");
    fs::path file = folder / "settings.toml";
};

Settings all_changed() {
    Settings settings;
    settings.text_size = 1.25;
    settings.width = 1600;
    settings.height = 900;
    settings.hides_panels = true;
    settings.dismissed_start = true;
    settings.opens_legend = true;
    settings.shown.show(Thing::trace, true);
    settings.shown.show(Thing::normal, false);
    settings.recent = {"/a b/bone ü.glb", "/tmp/\"\\\n\x7f.rec"};
    return settings;
}

TEST_F(WindowSettings, AreReadAsTheyWereWritten) {
    write_settings(folder / "new" / "settings", all_changed());
    EXPECT_EQ(read_settings(folder / "new" / "settings"), all_changed());
    write_settings(file, {});
    EXPECT_EQ(read_settings(file), Settings());
    Settings bare;
    for (const OverlayStyle &look : kThings) {
        bare.shown.show(look.thing, false);
    }
    write_settings(file, bare);
    EXPECT_EQ(read_settings(file), bare);
}

TEST_F(WindowSettings, AreTheDefaultsWithoutAFile) {
    EXPECT_EQ(read_settings(file), Settings());
    EXPECT_EQ(read_settings(""), Settings());
    SettingsKeeper none("");
    none.now = all_changed();
    none.save();
    none.reset();
    EXPECT_FALSE(none.remembers());
    EXPECT_EQ(none.take_error(), "");
}

TEST_F(WindowSettings, ThatAreDamagedAreNamedByFileAndLine) {
    const std::vector<std::pair<std::string, std::string>> damaged{
        {"springdrive settings 1\n", ":1: is not valid TOML"},
        {std::string("\0\xff\n", 3), ":1: is not valid TOML"},
        {"scale = 2\n", ":1: scale is not known"},
        {"\ntext_size = \"2\"\n", ":2: text_size is '2'; it must be a number from 0.5 to 3"},
        {"text_size = 3.01\n", ":1: text_size is 3.01"},
        {"width = 800\n", ":1: height is missing"},
        {"width = 800\nheight = 239\n", ":2: height is 239"},
        {"width = 800.5\nheight = 600\n", ":1: width is 800.5"},
        {"hides_panels = 1\n", ":1: hides_panels is 1; it must be true or false"},
        {"recent = [\"bone.glb\"]\n", ":1: recent has 'bone.glb'; each must be an absolute path"},
        {"recent = [\"/1\", \"/2\", \"/3\", \"/4\", \"/5\", \"/6\", \"/7\", \"/8\", \"/9\"]",
         ":1: recent"},
        {"drawn = [\"tip\", \"tail\"]\n", ":1: drawn has 'tail'; it must be a list"},
    };
    for (const auto &[text, error] : damaged) {
        write(text);
        const std::string said = testing::error_text_of([&] { (void)read_settings(file); });
        EXPECT_NE(said.find(file.string() + error), std::string::npos) << said;
        EXPECT_NE(said.find("--reset-settings"), std::string::npos) << said;
        EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    }
    write("text_size = 0.5\nwidth = 320\nheight = 16384\n"); // the ends of the ranges
    EXPECT_EQ(read_settings(file).text_size, 0.5);
    EXPECT_EQ(read_settings(file).height, 16384);
}

TEST_F(WindowSettings, ThatAreDamagedAreKeptBesideTheNewOnes) {
    for (const char *name : {"settings.damaged", "settings-2.damaged"}) {
        write("typed by hand\n");
        SettingsKeeper keeper(file);
        EXPECT_EQ(keeper.now, Settings());
        EXPECT_NE(keeper.take_error().find(":1: is not valid TOML"), std::string::npos);
        EXPECT_EQ(keeper.take_error(), ""); // once
        keeper.save();
        EXPECT_EQ(testing::contents_of(file), "typed by hand\n"); // nothing has changed
        keeper.now = all_changed();
        keeper.save();
        EXPECT_EQ(keeper.take_error(), "");
        EXPECT_EQ(read_settings(file), all_changed());
        EXPECT_EQ(testing::contents_of(folder / name), "typed by hand\n");
    }
}

TEST_F(WindowSettings, ThatCannotBeWrittenAreUsedAndSaidOnce) {
    write("not a folder");
    // No user may create files in /proc, root neither.
    for (const fs::path &where :
         {file / "springdrive" / "settings", fs::path("/proc/springdrive/settings")}) {
        SettingsKeeper keeper(where);
        EXPECT_EQ(keeper.take_error(), ""); // there are none
        keeper.now.hides_panels = true;
        keeper.save();
        const std::string said = keeper.take_error();
        EXPECT_NE(said.find(where.string()), std::string::npos) << said;
        EXPECT_NE(said.find("not remembered"), std::string::npos) << said;
        EXPECT_EQ(said.find('\n'), std::string::npos) << said;
        keeper.save();
        EXPECT_EQ(keeper.take_error(), "");
        EXPECT_TRUE(keeper.now.hides_panels); // for this run
    }
    EXPECT_EQ(testing::contents_of(file), "not a folder");
    SettingsKeeper device("/dev/full");
    EXPECT_NE(device.take_error().find("/dev/full: "), std::string::npos);
}

TEST_F(WindowSettings, AreAsTheyWereWhenTheDiskIsFull) {
    write_settings(file, all_changed());
    SettingsKeeper keeper(file);
    keeper.now.text_size = 2.0;
    {
        const testing::FullDisk full(10);
        keeper.save();
    }
    EXPECT_NE(keeper.take_error().find("is the disk full?"), std::string::npos);
    EXPECT_EQ(read_settings(file), all_changed());
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1); // no remains
    keeper.now.text_size = 2.5;
    keeper.save(); // there is room again
    EXPECT_EQ(read_settings(file).text_size, 2.5);
}

TEST_F(WindowSettings, ResetRemovesTheFile) {
    write_settings(file, all_changed());
    SettingsKeeper keeper(file);
    EXPECT_EQ(keeper.now, all_changed());
    keeper.reset();
    EXPECT_EQ(keeper.now, Settings());
    EXPECT_FALSE(fs::exists(file));
    keeper.reset(); // there is none
    EXPECT_EQ(keeper.take_error(), "");
    keeper.now = all_changed();
    keeper.save();
    EXPECT_EQ(read_settings(file), all_changed());
}

TEST_F(WindowSettings, RememberTheNewestFilesOnce) {
    Settings settings;
    for (int i = 0; i < 12; ++i) {
        note_recent(settings, "/scenes/" + std::to_string(i) + ".glb");
    }
    ASSERT_EQ(settings.recent.size(), Settings::kMaxRecent);
    EXPECT_EQ(settings.recent.front(), "/scenes/11.glb");
    EXPECT_EQ(settings.recent.back(), "/scenes/4.glb");
    note_recent(settings, "/scenes/x/../4.glb");
    EXPECT_EQ(settings.recent.size(), Settings::kMaxRecent);
    EXPECT_EQ(settings.recent.front(), "/scenes/4.glb");
    const Settings before = settings;
    note_recent(settings, "/scenes/\xff.glb");
    note_recent(settings, "");
    EXPECT_EQ(settings, before);
    note_recent(settings, "here.rec");
    EXPECT_EQ(settings.recent.front(), fs::current_path() / "here.rec");
    write_settings(file, settings);
    EXPECT_EQ(read_settings(file), settings);
}

TEST(TextSize, GoesInStepsToItsEndsAndBack) {
    double size = 1.0;
    int steps = 0;
    for (; next_text_size(size, true) > size; ++steps) {
        size = next_text_size(size, true);
    }
    EXPECT_EQ(size, kMaxTextSize);
    for (; steps > 0; --steps) {
        size = next_text_size(size, false);
    }
    EXPECT_EQ(size, 1.0);
    while (next_text_size(size, false) < size) {
        size = next_text_size(size, false);
    }
    EXPECT_EQ(size, kMinTextSize);
    EXPECT_EQ(next_text_size(1.1, true), 1.25); // from between two steps
    EXPECT_EQ(next_text_size(1.1, false), 1.0);
}

} // namespace
} // namespace springdrive::app
