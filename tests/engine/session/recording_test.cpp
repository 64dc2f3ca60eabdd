// Covers engine/session/recording.cpp alone.
#include "engine/session/recording.h"

#include "base/input_error.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/record/record_reader.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <string>

namespace springdrive::session {
namespace {

const Vector3 kRecordedStart_m(0.0, 0.02, 0.0);

class RecordingTest : public ::testing::Test {
protected:
    RecordingTest() : folder(testing::fresh_folder("recording")) {}
    ~RecordingTest() override { std::filesystem::remove_all(folder); }

    void tick(int ticks) {
        run.advance(1e-3 * ticks);
        recording.pump();
    }
    void take_another_device() {
        run.stop();
        recording.end_part(R"({"device":"exchanged"})");
        run.renew(another);
    }

    std::filesystem::path folder;
    simulated::SimulatedPhantom phantom{testing::phantom_1_0(), {}, kRecordedStart_m};
    simulated::SimulatedPhantom another{testing::phantom_1_0(), {}, kRecordedStart_m};
    ServoRun run{phantom, {1000.0, true, std::nullopt}};
    Recording recording{run};
};

std::uint64_t rows_of(const std::filesystem::path &file) {
    std::uint64_t rows = 0;
    for (record::RecordReader reader(file); reader.next();) {
        rows += reader.rows();
    }
    return rows;
}

TEST_F(RecordingTest, CountsAllPartsTogether) {
    tick(10);
    recording.start(folder / "touch.rec", record::record_header(1000.0));
    tick(100);
    take_another_device();
    EXPECT_EQ(recording.begin_part(record::record_header(1000.0)), folder / "touch-2.rec");
    EXPECT_TRUE(recording.is_running());
    tick(30);
    recording.stop();
    tick(5);
    EXPECT_FALSE(recording.is_running());
    EXPECT_EQ(recording.status().rows, 130U);
    EXPECT_EQ(rows_of(folder / "touch.rec"), 100U);
    EXPECT_EQ(rows_of(folder / "touch-2.rec"), 30U);
    EXPECT_EQ(recording.file(), folder / "touch-2.rec");
    recording.start(folder / "next.rec", record::record_header(1000.0)); // another recording
    tick(7);
    recording.stop();
    EXPECT_EQ(recording.status().rows, 7U);
    EXPECT_EQ(recording.parts().size(), 1U);
}

TEST_F(RecordingTest, ANewDeviceDoesNotStartARecording) {
    take_another_device();
    EXPECT_TRUE(recording.begin_part(record::record_header(1000.0)).empty());
    EXPECT_TRUE(recording.parts().empty());
    EXPECT_TRUE(std::filesystem::is_empty(folder));
}

TEST_F(RecordingTest, APartThatCannotBeCreatedIsReportedAndEndsTheRecording) {
    recording.start(folder / "touch.rec", record::record_header(1000.0));
    tick(10);
    take_another_device();
    record::RecordHeader impossible = record::record_header(1000.0);
    std::filesystem::remove_all(folder);
    EXPECT_THROW(recording.begin_part(impossible), InputError);
    EXPECT_FALSE(recording.is_running());
    EXPECT_NE(recording.status().error, "");
    EXPECT_EQ(recording.status().rows, 10U);
}

} // namespace
} // namespace springdrive::session
