// Covers what the window keeps in files. app/panels/session_keeper.cpp and, with the folders that
// it makes, record_commands.cpp: whatever happens between two keeps, no tick that was in memory is
// missing in the folder, and all of them are replayed to the last bit.
// app/panels/window_habits.cpp: what is remembered, and files that are damaged or cannot be
// written.
#include "app/panels/session_keeper.h"

#include "app/panels/window_habits.h"
#include "base/input_error.h"
#include "engine/record/record_file.h"
#include "tests/engine/session/session_fixture.h"
#include "tests/support/files.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

namespace fs = std::filesystem;

void write_text(const fs::path &file, const std::string &text) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
}

/// Replaces the first `part` of a file.
void change(const fs::path &file, const std::string &part, const std::string &by) {
    std::string text = testing::contents_of(file);
    const std::size_t at = text.find(part);
    ASSERT_NE(at, std::string::npos) << part;
    write_text(file, text.replace(at, part.size(), by));
}

testing::Ending replay(const fs::path &folder, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"replay", folder.string()});
    return testing::run_program(more);
}

/// @param status  which it ends with, without a line of error
void expect_replay(const fs::path &folder, int status, const std::vector<std::string> &says,
                   const std::vector<std::string> &more = {}) {
    const testing::Ending ending = replay(folder, more);
    EXPECT_EQ(ending.exit_status, status) << ending.out;
    EXPECT_EQ(ending.error, "");
    for (const std::string &part : says) {
        EXPECT_NE(ending.out.find(part), std::string::npos) << part << " in\n" << ending.out;
    }
}

/// A session in the window, as it is kept.
class Played {
public:
    explicit Played(const fs::path &parent,
                    const session::SessionOptions &options = testing::scripted())
        : session(options), keeper(parent) {
        session.start();
    }

    void run(double seconds) {
        for (int frame = 0; frame < static_cast<int>(std::round(seconds * 60.0)); ++frame) {
            advance();
        }
    }
    void advance() {
        session.advance(testing::kFrame_s);
        log.update(session);
        keeper.update(session);
    }
    void keep() {
        keeper.keep(session, log);
        while (keeper.is_writing()) {
            keeper.update(session);
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    }
    void finish() {
        session.stop();
        keeper.finish(session, log);
    }
    void exchange(const session::DeviceChoice &choice) {
        session.exchange_device(choice);
        for (int frame = 0; session.is_exchanging() && frame < 300; ++frame) {
            run(testing::kFrame_s);
        }
        ASSERT_FALSE(session.is_exchanging());
    }
    void set_K_P(double K_P_V_per_rad) {
        control::Tuning to = session.tuning().now();
        to.K_P_V_per_rad = K_P_V_per_rad;
        session.tuning().replace(to, session.plot_time_s(), "K_P of\n\"a, preset\"");
    }

    /// The ticks of each device in the folder's records, by the session's time of its start.
    [[nodiscard]] std::map<double, std::set<std::uint64_t>> ticks() const {
        std::map<double, std::set<std::uint64_t>> found;
        for (const session::RunRecord &record : session::read_run(keeper.folder()).records) {
            record::RecordReader reader(keeper.folder() / record.file);
            reader.for_each([&](const servo::ServoSample &sample) {
                found[record.start_s].insert(sample.tick);
            });
        }
        return found;
    }
    /// Of its only device.
    void expect_all_is_kept() const {
        EXPECT_EQ(keeper.error(), "");
        const std::set<std::uint64_t> found = ticks().at(0.0);
        EXPECT_EQ(found.size(), session.latest().tick + 1);
        EXPECT_EQ(*found.begin(), 0U);
        EXPECT_EQ(*found.rbegin(), session.latest().tick);
        expect_replays();
    }
    void expect_replays() const {
        const testing::Ending ending = replay(keeper.folder());
        EXPECT_EQ(ending.exit_status, 0) << ending.out << ending.error;
        EXPECT_EQ(ending.out.find("not recorded"), std::string::npos) << ending.out;
        EXPECT_EQ(ending.out.find("differs"), std::string::npos) << ending.out;
    }

    session::Session session;
    EventLog log;
    SessionKeeper keeper;
};

class SessionKeeperTest : public ::testing::Test {
protected:
    fs::path parent = testing::fresh_folder("session_keeper");
    Played played{parent};
};

TEST_F(SessionKeeperTest, MakesAFolderOnlyForWhatIsToBeKept) {
    const fs::path above = parent / "documents/springdrive";
    Played other(above);
    other.run(0.1);
    EXPECT_FALSE(fs::exists(parent / "documents"));
    other.keep();
    EXPECT_EQ(other.keeper.error(), "");
    EXPECT_EQ(other.keeper.folder().parent_path(), above);
    other.finish();
    played.run(0.5);
    played.finish();
    EXPECT_TRUE(played.keeper.folder().empty());
    EXPECT_EQ(std::distance(fs::directory_iterator(parent), {}), 1); // the documents
}

TEST_F(SessionKeeperTest, KeepsThePastWhoseSizeItSaysAndWhatFollows) {
    EXPECT_EQ(played.keeper.bytes_to_write(played.session), 0U);
    played.run(2.0);
    const std::uint64_t said = played.keeper.bytes_to_write(played.session);
    played.keep();
    EXPECT_TRUE(played.keeper.is_kept()) << played.keeper.error();
    EXPECT_EQ(played.keeper.bytes_to_write(played.session), 0U);
    const fs::path past = played.keeper.folder() / "past.rec";
    const std::uint64_t header = fs::file_size(past) - said;
    const std::string text = testing::contents_of(past).substr(12, header - 16);
    EXPECT_EQ(text.front(), '{');
    EXPECT_EQ(text.back(), '}');
    played.run(1.0);
    played.keep(); // once more: no further file is needed
    played.run(0.5);
    played.finish();
    EXPECT_EQ(session::read_run(played.keeper.folder()).records.size(), 2U);
    played.expect_all_is_kept();
}

TEST_F(SessionKeeperTest, KeepsWhatCameAfterAStoppedRecording) {
    played.run(1.0);
    played.keep();
    played.run(1.0);
    played.session.recording().stop();
    played.run(3.0);
    played.keep();
    EXPECT_TRUE(played.session.recording().is_running()); // from now on again
    played.run(0.5);
    played.session.recording().stop();
    played.run(0.5);
    played.finish();
    played.expect_all_is_kept();
}

TEST_F(SessionKeeperTest, ListsARecordThatRunsElsewhere) {
    played.run(0.5);
    played.session.start_recording(parent / "mine.rec");
    played.run(0.5);
    played.keep();
    played.run(0.5);
    played.session.recording().stop();
    played.run(1.0);
    played.finish();
    bool is_listed = false;
    for (const session::RunRecord &record : session::read_run(played.keeper.folder()).records) {
        is_listed = is_listed || record.file == fs::absolute(parent / "mine.rec");
    }
    EXPECT_TRUE(is_listed);
    played.expect_all_is_kept();
}

TEST_F(SessionKeeperTest, KeepsThePastOfEarlierDevicesAndReplaysEachWithItsOwn) {
    EXPECT_TRUE(testing::press(played.session));
    played.run(1.0);
    played.exchange(testing::premium());
    const std::string second = played.session.description().name;
    EXPECT_TRUE(testing::press(played.session));
    played.set_K_P(4.0);
    played.run(0.5);
    played.keep();
    played.set_K_P(5.0);
    played.exchange(testing::premium()); // and those that follow, each from its tick 0
    played.run(1.0);
    played.finish();
    EXPECT_EQ(played.keeper.error(), "");
    const fs::path folder = played.keeper.folder();
    const session::RunFacts facts = session::read_run(folder);
    ASSERT_EQ(facts.devices.size(), 3U);
    for (const session::RunRecord &record : facts.records) {
        const record::RecordHeader header = record::RecordReader(folder / record.file).header();
        EXPECT_EQ(header.device_name == second, record.device > 0);
        EXPECT_EQ(header.device_toml, facts.devices[record.device].toml);
    }
    const auto found = played.ticks();
    ASSERT_EQ(found.size(), 3U);
    std::uint64_t of_all = 0;
    for (const auto &[start_s, of_device] : found) {
        EXPECT_EQ(*of_device.begin(), 0U);
        EXPECT_EQ(*of_device.rbegin() + 1, of_device.size());
        of_all += of_device.size();
    }
    EXPECT_EQ(of_all, played.session.servo().history().store().end());
    played.expect_replays();
    change(folder / "run.json", R"("device": "device-2.toml")", R"("device": "device.toml")");
    EXPECT_EQ(replay(folder).exit_status, 1);
}

TEST_F(SessionKeeperTest, TriesAgainWhatAFullDiskPrevented) {
    played.run(4.0);
    {
        const testing::FullDisk full(200'000);
        played.keep();
        played.run(0.5);
        EXPECT_FALSE(played.keeper.is_kept());
        EXPECT_NE(played.keeper.error(), "");
        played.keep(); // still full
        EXPECT_FALSE(played.keeper.is_kept());
    }
    played.run(0.5);
    played.keep();
    EXPECT_TRUE(played.keeper.is_kept()) << played.keeper.error();
    played.run(0.5);
    played.finish();
    played.expect_all_is_kept();
}

TEST_F(SessionKeeperTest, BeginsAnotherFolderIfItsOwnIsGone) {
    played.run(1.0);
    played.keep();
    fs::remove_all(fs::path(played.keeper.folder()));
    played.run(0.5);
    played.keeper.notes = "still here";
    played.keep();
    EXPECT_TRUE(played.keeper.is_kept()) << played.keeper.error();
    played.run(0.5);
    played.finish();
    EXPECT_EQ(session::read_run(played.keeper.folder()).notes, "still here");
    played.expect_all_is_kept();
}

TEST_F(SessionKeeperTest, ListsTheDeviceAsItIsNowButARecordAsItBegan) {
    played.run(0.5);
    played.session.set_delay(1.5);
    played.run(0.5);
    played.keep();
    simulated::PlantEffects effects = played.session.simulation().effects;
    effects.gravity = false;
    played.session.set_effects(effects);
    played.session.observe_resistance(false);
    played.run(0.5);
    played.keep();
    played.finish();
    const std::string text = testing::contents_of(played.keeper.folder() / "run.json");
    EXPECT_NE(text.find("\"gravity\": false"), std::string::npos) << text;
    EXPECT_NE(text.find("\"observes_resistance\": false"), std::string::npos) << text;
    const fs::path past = played.keeper.folder() / "past.rec";
    EXPECT_EQ(record::RecordReader(past).header().delay_periods, 0.0); // at its first tick
    const std::string notes = testing::notes_in(past);
    EXPECT_NE(notes.find("\"delay_periods\":1.5"), std::string::npos) << notes;
    const fs::path record = played.keeper.folder() / "record.rec";
    EXPECT_EQ(record::RecordReader(record).header().delay_periods, 1.5);
}

TEST_F(SessionKeeperTest, KeepsNotesThatWereNeverKept) {
    played.run(0.5);
    played.keeper.notes = "a thought";
    played.finish();
    ASSERT_FALSE(played.keeper.folder().empty());
    EXPECT_EQ(session::read_run(played.keeper.folder()).notes, "a thought");
    played.expect_all_is_kept();
}

class ReplayRun : public ::testing::Test {
protected:
    /// Changes of all kinds in contact, before and after it is kept.
    fs::path keep_one(const session::SessionOptions &options = testing::scripted()) const {
        Played played(parent, options);
        session::TuningHistory &tuning = played.session.tuning();
        const auto now_s = [&] { return played.session.plot_time_s(); };
        played.set_K_P(7.0); // before the first tick
        EXPECT_TRUE(testing::run_into_contact(played.session));
        played.set_K_P(8.0);
        played.run(1.0);
        tuning.toggle(now_s());
        tuning.toggle(now_s()); // within one frame: that in between is never active
        played.run(0.1);
        played.set_K_P(9.0); // on the way to another one
        played.keep();
        played.run(0.05);
        tuning.undo(now_s());
        played.run(0.5);
        control::Tuning dragged = tuning.now();
        for (int i = 0; i < 30; ++i) { // one step in each frame
            dragged.dR_Ohm = 0.5 + 0.02 * i;
            tuning.change(dragged, now_s(), 1);
            played.advance();
        }
        tuning.let_go();
        played.run(1.0);
        tuning.store(now_s());
        played.set_K_P(6.5);
        played.run(1.0);
        played.keep();
        played.set_K_P(12.0); // after it was saved
        played.run(0.5);
        played.session.stop();
        return played.keeper.folder();
    }

    fs::path parent = testing::fresh_folder("replay_run");
};

TEST_F(ReplayRun, IsEqualToTheLastBitInAllItsRecords) {
    const fs::path folder = keep_one();
    expect_replay(folder, 0,
                  {"2 of 2 records are as they must be",
                   "device                 as in the device file", "plate.gltf': as it was"});
    EXPECT_EQ(replay(folder).out.find("differs"), std::string::npos);
    expect_replay(folder, 0, {"e_W_V                  differs in", "2 of 2 records belong to this"},
                  {"--kp", "12"});
    testing::expect_refused(replay(folder, {"--csv", "-"}), "needs one record");
    testing::expect_refused(replay(folder, {"--kp", "-1"}), "--kp");
    testing::expect_refused(replay(parent), "has no run.json");
    fs::create_directory_symlink(folder, parent / "link");
    for (const fs::path &other : {folder / "record.rec", folder / "", parent / "link"}) {
        EXPECT_EQ(replay(other).exit_status, 0) << other;
    }

    // Each bad record is reported, and the others are replayed.
    const std::string past = testing::contents_of(folder / "past.rec");
    fs::remove(folder / "past.rec");
    expect_replay(folder, 1, {"past.rec: is missing", "1 of 2 records"});
    EXPECT_EQ(replay(folder, {"--kp", "12"}).exit_status, 1);
    write_text(folder / "past.rec", past.substr(0, past.size() - 10)); // its writer was killed
    expect_replay(folder, 1, {"the last chunk is incomplete"});
    write_text(folder / "past.rec", "no record");
    expect_replay(folder, 1, {"past.rec: is not a springdrive record", "1 of 2 records"});
    write_text(folder / "past.rec", past);
    change(folder / "device.toml", "\n", "\n\n");
    expect_replay(folder, 1, {"differs from the device file", "0 of 2 records"});
    change(folder / "run.json", "\"past.rec\"", "\"../past.rec\"");
    testing::expect_refused(replay(folder), "records[0].file is '../past.rec'");
}

TEST_F(ReplayRun, ByTheClockIsEqualToo) {
    session::SessionOptions options = testing::scripted();
    options.lockstep = false;
    options.servo_hz = 2000.0;
    Played played(parent, options);
    ASSERT_TRUE(testing::run_into_contact(played.session));
    for (const double K_P_V_per_rad : {8.0, 5.0, 7.0, 6.0, 9.0, 8.0}) {
        if (K_P_V_per_rad == 6.0) {
            played.keep();
        }
        played.set_K_P(K_P_V_per_rad);
        for (int frame = 0; frame < 20; ++frame) {
            played.advance();
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
    }
    played.finish();
    played.expect_replays();
}

TEST_F(ReplayRun, NeedsNoScene) {
    fs::copy(testing::assets() / "scenes", parent / "scenes");
    session::SessionOptions options = testing::scripted();
    options.scene = parent / "scenes/plate.gltf";
    const fs::path folder = keep_one(options);
    write_text(options.scene, testing::contents_of(options.scene) + "\n");
    expect_replay(folder, 0, {"plate.gltf': has changed since"});
    fs::remove(options.scene);
    expect_replay(folder, 0, {"plate.gltf': not found"});
}

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
        const std::string said = error_text_of([&] { (void)read_settings(file); });
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
