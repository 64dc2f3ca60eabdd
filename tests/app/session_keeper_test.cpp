// Covers app/panels/session_keeper.cpp: whatever happens between two keeps, no tick that was in
// memory is missing in the folder.
#include "app/panels/session_keeper.h"

#include "engine/record/record_reader.h"
#include "tests/engine/session/session_fixture.h"
#include "tests/support/full_disk.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <set>
#include <thread>

namespace springdrive::app {
namespace {

class SessionKeeperTest : public ::testing::Test {
protected:
    SessionKeeperTest() { played.start(); }

    void run(double seconds) {
        for (int frame = 0; frame < static_cast<int>(std::round(seconds * 60.0)); ++frame) {
            played.advance(testing::kFrame_s);
            log.update(played);
            keeper.update(played);
        }
    }
    void keep() {
        keeper.keep(played, log);
        while (keeper.is_writing()) {
            keeper.update(played);
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    }
    void finish() {
        played.stop();
        keeper.finish(played, log);
    }
    void exchange() {
        played.exchange_device(testing::premium());
        for (int frame = 0; played.is_exchanging() && frame < 300; ++frame) {
            run(testing::kFrame_s);
        }
        ASSERT_FALSE(played.is_exchanging());
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
    void expect_all_of(const std::set<std::uint64_t> &found, std::uint64_t last) const {
        EXPECT_EQ(found.size(), last + 1);
        EXPECT_EQ(*found.begin(), 0U);
        EXPECT_EQ(*found.rbegin(), last);
    }
    /// By the program.
    void expect_replays() const {
        const testing::Ending ending = testing::run_program({"replay", keeper.folder()});
        EXPECT_EQ(ending.exit_status, 0) << ending.out << ending.error;
        EXPECT_EQ(ending.out.find("not recorded"), std::string::npos) << ending.out;
    }

    std::filesystem::path parent = testing::fresh_folder("session_keeper");
    session::Session played{testing::scripted()};
    EventLog log;
    SessionKeeper keeper{parent};
};

TEST_F(SessionKeeperTest, MakesTheFolderAboveOnlyWithTheFirstOfItsFolders) {
    const std::filesystem::path above = parent / "documents/springdrive";
    SessionKeeper other(above);
    run(0.1);
    EXPECT_FALSE(std::filesystem::exists(parent / "documents"));
    other.keep(played, log);
    EXPECT_EQ(other.error(), "");
    EXPECT_EQ(other.folder().parent_path(), above);
    played.stop();
    other.finish(played, log);
}

TEST_F(SessionKeeperTest, KeepsThePastAndWhatFollows) {
    run(2.0);
    keep();
    EXPECT_TRUE(keeper.is_kept()) << keeper.error();
    run(1.0);
    keep(); // once more: no further file is needed
    run(0.5);
    finish();
    EXPECT_EQ(keeper.error(), "");
    EXPECT_EQ(session::read_run(keeper.folder()).records.size(), 2U);
    expect_all_of(ticks().at(0.0), played.latest().tick);
    expect_replays();
}

TEST_F(SessionKeeperTest, SaysTheSizeOfThePastBeforeItIsWritten) {
    EXPECT_EQ(keeper.bytes_to_write(played), 0U);
    run(2.0);
    const std::uint64_t said = keeper.bytes_to_write(played);
    keep();
    EXPECT_EQ(keeper.bytes_to_write(played), 0U);
    const std::filesystem::path past = keeper.folder() / "past.rec";
    const std::uint64_t header = std::filesystem::file_size(past) - said;
    const std::string json = testing::contents_of(past).substr(12, header - 16);
    EXPECT_EQ(json.front(), '{');
    EXPECT_EQ(json.back(), '}');
    finish();
}

TEST_F(SessionKeeperTest, KeepsWhatCameAfterAStoppedRecording) {
    run(1.0);
    keep();
    run(1.0);
    played.recording().stop();
    run(3.0);
    keep();
    EXPECT_TRUE(played.recording().is_running()); // from now on again
    run(0.5);
    played.recording().stop();
    run(0.5);
    finish();
    EXPECT_EQ(keeper.error(), "");
    expect_all_of(ticks().at(0.0), played.latest().tick);
    expect_replays();
}

TEST_F(SessionKeeperTest, ListsARecordThatRunsElsewhere) {
    run(0.5);
    played.start_recording(parent / "mine.rec");
    run(0.5);
    keep();
    run(0.5);
    played.recording().stop();
    run(1.0);
    finish();
    EXPECT_EQ(keeper.error(), "");
    bool is_listed = false;
    for (const session::RunRecord &record : session::read_run(keeper.folder()).records) {
        is_listed = is_listed || record.file == std::filesystem::absolute(parent / "mine.rec");
    }
    EXPECT_TRUE(is_listed);
    expect_all_of(ticks().at(0.0), played.latest().tick);
    expect_replays();
}

TEST_F(SessionKeeperTest, KeepsThePastOfEarlierDevices) {
    run(3.0);
    exchange();
    const std::string second = played.description().name;
    run(2.0);
    keep();
    exchange(); // and those that follow, each from its tick 0
    run(1.0);
    finish();
    EXPECT_EQ(keeper.error(), "");
    const session::RunFacts facts = session::read_run(keeper.folder());
    ASSERT_EQ(facts.devices.size(), 3U);
    for (const session::RunRecord &record : facts.records) {
        const record::RecordHeader header =
            record::RecordReader(keeper.folder() / record.file).header();
        EXPECT_EQ(header.device_name == second, record.device > 0);
        EXPECT_EQ(header.device_toml, facts.devices[record.device].toml);
    }
    const auto found = ticks();
    ASSERT_EQ(found.size(), 3U);
    std::uint64_t of_all = 0;
    for (const auto &[start_s, of_device] : found) {
        expect_all_of(of_device, *of_device.rbegin());
        of_all += of_device.size();
    }
    EXPECT_EQ(of_all, played.servo().history().store().end());
    expect_replays();
}

TEST_F(SessionKeeperTest, TriesAgainWhatAFullDiskPrevented) {
    run(4.0);
    {
        const testing::FullDisk full(200'000);
        keep();
        run(0.5);
        EXPECT_FALSE(keeper.is_kept());
        EXPECT_NE(keeper.error(), "");
        keep(); // still full
        EXPECT_FALSE(keeper.is_kept());
    }
    run(0.5);
    keep();
    EXPECT_TRUE(keeper.is_kept()) << keeper.error();
    run(0.5);
    finish();
    EXPECT_EQ(keeper.error(), "");
    expect_all_of(ticks().at(0.0), played.latest().tick);
    expect_replays();
}

TEST_F(SessionKeeperTest, BeginsAnotherFolderIfItsOwnIsGone) {
    run(1.0);
    keep();
    const std::filesystem::path first = keeper.folder();
    std::filesystem::remove_all(first);
    run(0.5);
    keeper.notes = "still here";
    keep();
    EXPECT_TRUE(keeper.is_kept()) << keeper.error();
    run(0.5);
    finish();
    EXPECT_EQ(session::read_run(keeper.folder()).notes, "still here");
    expect_all_of(ticks().at(0.0), played.latest().tick);
    expect_replays();
}

TEST_F(SessionKeeperTest, ListsTheDeviceAsItIsNow) {
    run(0.5);
    keep();
    simulated::PlantEffects effects = played.simulation().effects;
    effects.gravity = false;
    played.set_effects(effects);
    played.observe_resistance(false);
    run(0.5);
    keep();
    const std::string json = testing::contents_of(keeper.folder() / "run.json");
    EXPECT_NE(json.find("\"gravity\": false"), std::string::npos) << json;
    EXPECT_NE(json.find("\"observes_resistance\": false"), std::string::npos) << json;
}

TEST_F(SessionKeeperTest, KeepsNotesThatWereNeverKept) {
    run(0.5);
    keeper.notes = "a thought";
    finish();
    ASSERT_FALSE(keeper.folder().empty());
    EXPECT_EQ(session::read_run(keeper.folder()).notes, "a thought");
    expect_all_of(ticks().at(0.0), played.latest().tick);
}

TEST_F(SessionKeeperTest, LeavesNothingIfNothingIsToBeKept) {
    run(0.5);
    finish();
    EXPECT_TRUE(keeper.folder().empty());
    EXPECT_TRUE(std::filesystem::is_empty(parent));
}

TEST_F(SessionKeeperTest, TheRecordBeginsAsTheDeviceWasThen) {
    run(0.5);
    played.set_delay(1.5);
    run(0.5);
    keep();
    finish();
    const std::filesystem::path past = keeper.folder() / "past.rec";
    EXPECT_EQ(record::RecordReader(past).header().delay_periods, 0.0); // at its first tick
    const std::string notes = testing::notes_in(past);
    EXPECT_NE(notes.find("\"delay_periods\":1.5"), std::string::npos) << notes;
    EXPECT_EQ(record::RecordReader(keeper.folder() / "record.rec").header().delay_periods, 1.5);
}

} // namespace
} // namespace springdrive::app
