// Covers engine/session/recording.cpp, by itself.
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
    RecordingTest() : folder_(testing::fresh_folder("recording")) {}
    ~RecordingTest() override { std::filesystem::remove_all(folder_); }

    void tick(int ticks) {
        run_.advance(1e-3 * ticks);
        recording_.pump();
    }
    void take_another_device() {
        run_.stop();
        recording_.end_part(R"({"device":"exchanged"})");
        run_.renew(other_);
    }

    std::filesystem::path folder_;
    simulated::SimulatedPhantom device_{testing::phantom_1_0(), {}, kRecordedStart_m};
    simulated::SimulatedPhantom other_{testing::phantom_1_0(), {}, kRecordedStart_m};
    ServoRun run_{device_, {1000.0, true, std::nullopt}};
    Recording recording_{run_};
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
    recording_.start(folder_ / "touch.rec", record::record_header(1000.0));
    tick(100);
    take_another_device();
    EXPECT_EQ(recording_.begin_part(record::record_header(1000.0)), folder_ / "touch-2.rec");
    EXPECT_TRUE(recording_.is_running());
    tick(30);
    recording_.stop();
    tick(5);
    EXPECT_FALSE(recording_.is_running());
    EXPECT_EQ(recording_.status().rows, 130U);
    EXPECT_EQ(rows_of(folder_ / "touch.rec"), 100U);
    EXPECT_EQ(rows_of(folder_ / "touch-2.rec"), 30U);
    EXPECT_EQ(recording_.file(), folder_ / "touch-2.rec");
    recording_.start(folder_ / "next.rec", record::record_header(1000.0)); // another recording
    tick(7);
    recording_.stop();
    EXPECT_EQ(recording_.status().rows, 7U);
    EXPECT_EQ(recording_.parts().size(), 1U);
}

TEST_F(RecordingTest, WithoutOneAnotherDeviceBeginsNone) {
    take_another_device();
    EXPECT_TRUE(recording_.begin_part(record::record_header(1000.0)).empty());
    EXPECT_TRUE(recording_.parts().empty());
    EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST_F(RecordingTest, APartThatCannotBeMadeIsSaidAndEndsIt) {
    recording_.start(folder_ / "touch.rec", record::record_header(1000.0));
    tick(10);
    take_another_device();
    record::RecordHeader impossible = record::record_header(1000.0);
    std::filesystem::remove_all(folder_);
    EXPECT_THROW(recording_.begin_part(impossible), InputError);
    EXPECT_FALSE(recording_.is_running());
    EXPECT_NE(recording_.status().error, "");
    EXPECT_EQ(recording_.status().rows, 10U);
}

TEST(Recording, NamesPartsByTheFirst) {
    EXPECT_EQ(name_of_part("a/touch.rec", 2), "a/touch-2.rec");
    EXPECT_EQ(name_of_part("touch", 10), "touch-10");
    EXPECT_EQ(name_of_part("a.b/x.y.rec", 3), "a.b/x.y-3.rec");
}

} // namespace
} // namespace springdrive::session
