// Covers app/commands/replay_command.cpp with the folders of kept sessions; record_command_test.cpp
// covers it with records.
#include "engine/session/run_folder.h"
#include "engine/session/session.h"
#include "tests/engine/session/session_fixture.h"
#include "tests/support/devices.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

using testing::contents_of;

void write_text(const std::filesystem::path &file, const std::string &text) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
}

/// Replaces the first `part` of a file.
void change(const std::filesystem::path &file, const std::string &part, const std::string &by) {
    std::string text = contents_of(file);
    const std::size_t at = text.find(part);
    ASSERT_NE(at, std::string::npos) << part;
    write_text(file, text.replace(at, part.size(), by));
}

bool says(const testing::Ending &ending, const std::string &part) {
    return ending.out.find(part) != std::string::npos;
}

/// A session that is tuned and kept as in the window.
class PlayedSession {
public:
    explicit PlayedSession(const session::SessionOptions &options)
        : session(options), tuning(session.tuning()) {
        session.start();
    }

    [[nodiscard]] const record::ChannelStore &store() const {
        return session.servo().history().store();
    }
    [[nodiscard]] double now_s() const { return session.plot_time_s(); }
    void set_K_P(double K_P_V_per_rad) {
        control::Tuning to = tuning.now();
        to.K_P_V_per_rad = K_P_V_per_rad;
        tuning.replace(to, now_s(), "K_P of\n\"a, preset\"");
    }
    /// One step in each frame.
    void drag_dR(double from_Ohm, double step_Ohm, int steps) {
        control::Tuning to = tuning.now();
        for (int i = 0; i < steps; ++i) {
            to.dR_Ohm = from_Ohm + step_Ohm * i;
            tuning.change(to, now_s(), 1);
            session.advance(testing::kFrame_s);
        }
        tuning.let_go();
    }
    void run(double seconds) { testing::run(session, seconds); }

    /// From here on, rows are of another device.
    void note_exchange(std::uint64_t first_row) {
        first_row_ = first_row;
        start_s_ = store().time_s(first_row);
    }

    [[nodiscard]] record::RecordHeader header() const {
        record::RecordHeader header = record::record_header(session.servo().rate_hz());
        header.device_toml = session.models().ground().memory.device_text;
        header.scene_file = session.scenes().now().scene.file.string();
        header.scene_sha256 = session.scenes().now().sha256;
        return header;
    }

    /// Writes the past, and records from now on.
    void keep(const std::filesystem::path &parent) {
        folder = session::RunFolder::create(parent);
        note_device();
        BackgroundTalk talk;
        session::write_record(
            folder->path() / "past.rec",
            {header(), session.description(), store(), {first_row_, store().end()}}, talk);
        facts.records = {{folder->path() / "past.rec", start_s_, 0}};
        session.start_recording(folder->path() / "record.rec");
        note_record();
    }
    void note_device() {
        session::RunDevice device;
        device.name = session.description().name;
        device.toml = header().device_toml;
        facts.devices.push_back(device);
    }
    void note_record() {
        facts.records.push_back({session.recording().file(), start_s_, facts.devices.size() - 1});
    }
    std::filesystem::path save() {
        tuning.let_go();
        facts.until_s = now_s();
        facts.servo_hz = session.servo().rate_hz();
        facts.scene = {session.scenes().now().scene.file.string(), session.scenes().now().sha256,
                       session.scenes().now().scene.surface.triangles.size()};
        facts.slots = tuning.slots();
        facts.journal = {tuning.journal().begin(), tuning.journal().end()};
        folder->save(facts);
        return folder->path();
    }

    session::Session session;
    session::TuningHistory &tuning;
    session::RunFacts facts;
    std::optional<session::RunFolder> folder;

private:
    std::uint64_t first_row_ = 0;
    double start_s_ = 0.0;
};

class ReplayRun : public ::testing::Test {
protected:
    ReplayRun() : parent(testing::fresh_folder("replay_run")) {}

    /// Changes of all kinds in contact, before and after it is kept.
    std::filesystem::path keep_one(const session::SessionOptions &options = testing::scripted()) {
        PlayedSession played(options);
        played.set_K_P(7.0); // before the first tick
        EXPECT_TRUE(testing::run_into_contact(played.session));
        played.set_K_P(8.0);
        played.run(1.0);
        played.tuning.toggle(played.now_s());
        played.tuning.toggle(played.now_s()); // within one frame: that in between is never active
        played.run(0.1);
        played.set_K_P(9.0); // on the way to another one
        played.keep(parent);
        played.run(0.05);
        played.tuning.undo(played.now_s());
        played.run(0.5);
        played.drag_dR(0.5, 0.02, 30);
        played.run(1.0);
        played.tuning.store(played.now_s());
        played.set_K_P(6.5);
        played.run(1.0);
        const std::filesystem::path folder = played.save();
        played.set_K_P(12.0); // after it was saved
        played.run(0.5);
        played.session.stop();
        return folder;
    }

    std::filesystem::path parent;
};

testing::Ending replay(const std::filesystem::path &folder, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"replay", folder.string()});
    return testing::run_program(more);
}

TEST_F(ReplayRun, IsEqualToTheLastBitInAllItsRecords) {
    const testing::Ending ending = replay(keep_one());
    EXPECT_EQ(ending.exit_status, 0) << ending.out << ending.error;
    EXPECT_EQ(ending.error, "");
    EXPECT_EQ(ending.out.find("differs"), std::string::npos) << ending.out;
    EXPECT_TRUE(says(ending, "2 of 2 records are as they must be")) << ending.out;
    EXPECT_TRUE(says(ending, "device                 as in the device file")) << ending.out;
    EXPECT_TRUE(says(ending, "plate.gltf': as it was")) << ending.out;
}

TEST_F(ReplayRun, ByTheClockIsEqualToo) {
    session::SessionOptions options = testing::scripted();
    options.lockstep = false;
    options.servo_hz = 2000.0;
    PlayedSession played(options);
    const auto frames = [&played](int count) {
        for (int i = 0; i < count; ++i) {
            played.session.advance(testing::kFrame_s);
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
    };
    ASSERT_TRUE(testing::run_into_contact(played.session));
    for (const double K_P_V_per_rad : {8.0, 5.0, 7.0}) {
        played.set_K_P(K_P_V_per_rad);
        frames(20);
    }
    played.keep(parent);
    for (const double K_P_V_per_rad : {6.0, 9.0, 8.0}) {
        played.set_K_P(K_P_V_per_rad);
        frames(20);
    }
    played.session.stop();
    const testing::Ending ending = replay(played.save());
    EXPECT_EQ(ending.exit_status, 0) << ending.out << ending.error;
}

TEST_F(ReplayRun, ReportsEachBadRecordAndReplaysTheOthers) {
    const std::filesystem::path folder = keep_one();
    const std::string past = contents_of(folder / "past.rec");
    std::filesystem::remove(folder / "past.rec");
    testing::Ending ending = replay(folder);
    EXPECT_EQ(ending.exit_status, 1);
    EXPECT_TRUE(says(ending, "past.rec: is missing")) << ending.out;
    EXPECT_TRUE(says(ending, "1 of 2 records")) << ending.out;
    write_text(folder / "past.rec", past.substr(0, past.size() - 10)); // its writer was killed
    ending = replay(folder);
    EXPECT_EQ(ending.exit_status, 1);
    EXPECT_TRUE(says(ending, "the last chunk is incomplete")) << ending.out;
    write_text(folder / "past.rec", "no record");
    ending = replay(folder);
    EXPECT_EQ(ending.exit_status, 1);
    EXPECT_TRUE(says(ending, "past.rec: is not a springdrive record")) << ending.out;
    EXPECT_TRUE(says(ending, "1 of 2 records")) << ending.out;
    write_text(folder / "past.rec", past);
    change(folder / "device.toml", "\n", "\n\n");
    ending = replay(folder);
    EXPECT_EQ(ending.exit_status, 1);
    EXPECT_TRUE(says(ending, "differs from the device file")) << ending.out;
    EXPECT_TRUE(says(ending, "0 of 2 records")) << ending.out;
}

TEST_F(ReplayRun, NeedsNoScene) {
    std::filesystem::copy(testing::assets() / "scenes", parent / "scenes");
    session::SessionOptions options = testing::scripted();
    options.scene = parent / "scenes/plate.gltf";
    const std::filesystem::path folder = keep_one(options);
    write_text(options.scene, contents_of(options.scene) + "\n");
    testing::Ending ending = replay(folder);
    EXPECT_EQ(ending.exit_status, 0) << ending.out;
    EXPECT_TRUE(says(ending, "plate.gltf': has changed since")) << ending.out;
    std::filesystem::remove(options.scene);
    ending = replay(folder);
    EXPECT_EQ(ending.exit_status, 0) << ending.out;
    EXPECT_TRUE(says(ending, "plate.gltf': not found")) << ending.out;
}

TEST_F(ReplayRun, OfSeveralDevicesComparesEachWithItsOwn) {
    PlayedSession played(testing::scripted());
    const auto exchange = [&played](const session::DeviceChoice &choice) {
        played.run(1.0);
        played.session.exchange_device(choice);
        while (played.session.is_exchanging()) {
            played.session.advance(0.001);
        }
        const std::uint64_t first_row = played.store().end();
        played.session.advance(0.001);
        played.note_exchange(first_row);
    };
    exchange(testing::premium());
    EXPECT_TRUE(testing::press(played.session));
    played.set_K_P(4.0);
    played.run(0.5);
    played.keep(parent);
    played.set_K_P(5.0);
    exchange(testing::scripted().device);
    played.note_device();
    played.note_record();
    EXPECT_TRUE(testing::press(played.session));
    played.set_K_P(6.0);
    played.run(0.5);
    played.session.stop();
    const std::filesystem::path folder = played.save();
    const testing::Ending ending = replay(folder);
    EXPECT_EQ(ending.exit_status, 0) << ending.out << ending.error;
    EXPECT_TRUE(says(ending, "3 of 3 records are as they must be")) << ending.out;
    EXPECT_EQ(contents_of(folder / "device-2.toml"), contents_of(testing::scripted().device.file));
    change(folder / "run.json", R"("device": "device-2.toml")", R"("device": "device.toml")");
    EXPECT_EQ(replay(folder).exit_status, 1);
}

TEST_F(ReplayRun, AnswersWhatAnotherTuningWouldHaveDone) {
    const std::filesystem::path folder = keep_one();
    const testing::Ending ending = replay(folder, {"--kp", "12"});
    EXPECT_EQ(ending.exit_status, 0) << ending.out << ending.error;
    EXPECT_TRUE(says(ending, "e_W_V                  differs in")) << ending.out;
    EXPECT_TRUE(says(ending, "2 of 2 records belong to this run")) << ending.out;
    std::filesystem::remove(folder / "record.rec");
    EXPECT_EQ(replay(folder, {"--kp", "12"}).exit_status, 1);
}

TEST_F(ReplayRun, MistakesAreSaidInOneLine) {
    const std::filesystem::path folder = keep_one();
    testing::expect_refused(replay(folder, {"--csv", "-"}), "needs one record");
    testing::expect_refused(replay(folder, {"--kp", "-1"}), "--kp");
    testing::expect_refused(replay(parent), "has no run.json");
    EXPECT_EQ(replay(folder / "record.rec").exit_status, 0);
    EXPECT_EQ(replay(folder.string() + "/").exit_status, 0);
    std::filesystem::create_directory_symlink(folder, parent / "link");
    EXPECT_EQ(replay(parent / "link").exit_status, 0);
    change(folder / "run.json", "\"past.rec\"", "\"../past.rec\"");
    testing::expect_refused(replay(folder), "records[0].file is '../past.rec'");
}

} // namespace
} // namespace springdrive::app
