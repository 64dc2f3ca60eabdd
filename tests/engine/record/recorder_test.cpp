// Covers engine/record/recorder.cpp; for a killed process see record_kill_test.cpp.
#include "engine/record/recorder.h"

#include "engine/record/record_reader.h"
#include "tests/engine/record/samples.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace springdrive::record {
namespace {

using testing::expected_bytes;
using testing::fresh_folder;
using Mode = Recorder::Mode;

servo::ServoSample sample_at(std::uint64_t tick) {
    servo::ServoSample sample;
    sample.tick = tick;
    return sample;
}

/// The ticks and notes of a file, in order: "0 1 2 {note} 3".
std::string log_of(const std::filesystem::path &file) {
    RecordReader reader(file);
    std::string log;
    reader.for_each(
        [&](const servo::ServoSample &sample) { log += std::to_string(sample.tick) + " "; },
        [&](std::string_view note) { log += "{" + std::string(note) + "} "; });
    EXPECT_EQ(reader.ending().why, "");
    return log;
}

void push(SampleRing<servo::ServoSample> &ring, std::uint64_t from, std::uint64_t to) {
    for (std::uint64_t tick = from; tick < to; ++tick) {
        ring.push(sample_at(tick));
    }
}

TEST(Recorder, RecordsWhatIsPumpedBetweenStartAndStop) {
    const auto file = fresh_folder("recorder_pumped") / "a.rec";
    SampleRing<servo::ServoSample> ring(16);
    Recorder recorder(ring);
    push(ring, 0, 3); // from before
    EXPECT_FALSE(recorder.is_recording());
    recorder.start(file, record_header(testing::kServo_hz), Mode::pumped);
    EXPECT_TRUE(recorder.is_recording());
    push(ring, 3, 10);
    recorder.pump();
    push(ring, 10, 15);
    recorder.note("scene");
    recorder.pump();
    push(ring, 15, 17);
    recorder.stop("end");
    EXPECT_FALSE(recorder.is_recording());
    EXPECT_EQ(log_of(file), "3 4 5 6 7 8 9 10 11 12 13 14 {scene} 15 16 {end} ");
    const RecorderStatus status = recorder.status();
    EXPECT_EQ(status.rows, 14U);
    EXPECT_EQ(status.bytes, std::filesystem::file_size(file));
    EXPECT_EQ(status.lost, 0U);
    EXPECT_EQ(status.error, "");
}

TEST(Recorder, CountsSamplesLostByTheRingOnce) {
    const auto file = fresh_folder("recorder_lost") / "a.rec";
    SampleRing<servo::ServoSample> ring(8);
    Recorder recorder(ring);
    push(ring, 0, 20); // loses 12, which are not the recording's
    recorder.start(file, record_header(testing::kServo_hz), Mode::pumped);
    EXPECT_EQ(recorder.status().lost, 0U);
    push(ring, 20, 31); // 3 lost
    recorder.pump();
    EXPECT_EQ(recorder.status().lost, 3U);
    push(ring, 31, 35);
    recorder.pump();
    EXPECT_EQ(recorder.status().lost, 3U);
    push(ring, 37, 39); // 2 never came
    recorder.pump();
    EXPECT_EQ(recorder.status().lost, 5U);
    recorder.stop();
    RecordReader reader(file);
    while (reader.next()) {
    }
    EXPECT_EQ(reader.ending().missing_ticks, 5U);
}

TEST(Recorder, RestartsWithFreshStatus) {
    const auto folder = fresh_folder("recorder_anew");
    SampleRing<servo::ServoSample> ring(8);
    Recorder recorder(ring);
    recorder.start(folder / "a.rec", record_header(testing::kServo_hz), Mode::pumped);
    push(ring, 0, 12);
    EXPECT_NE(testing::error_text_of([&] { // stops the first, too
                  recorder.start(folder / "a.rec", record_header(testing::kServo_hz), Mode::pumped);
              })
                  .find("exists already"),
              std::string::npos);
    EXPECT_FALSE(recorder.is_recording());
    recorder.start(folder / "b.rec", record_header(testing::kServo_hz), Mode::pumped);
    EXPECT_EQ(recorder.status().rows, 0U);
    EXPECT_EQ(recorder.status().lost, 0U);
    push(ring, 50, 52);
    recorder.stop();
    recorder.stop("twice");
    recorder.note("too late");
    recorder.pump();
    EXPECT_EQ(log_of(folder / "a.rec"), "0 1 2 3 4 5 6 7 ");
    EXPECT_EQ(log_of(folder / "b.rec"), "50 51 ");
}

TEST(Recorder, RejectsATooLongNote) {
    const auto file = fresh_folder("recorder_note") / "a.rec";
    SampleRing<servo::ServoSample> ring(8);
    Recorder recorder(ring);
    recorder.start(file, record_header(testing::kServo_hz), Mode::pumped);
    EXPECT_NE(testing::error_text_of(
                  [&] { recorder.note(std::string(RecordWriter::kMaxNote + 1, ' ')); }),
              "");
    recorder.stop();
    EXPECT_EQ(log_of(file), "");
}

/// Waits for a condition set by another thread, at most a minute.
template <typename Condition> bool comes_true(Condition &&condition) {
    for (int i = 0; i < 60'000 && !condition(); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return condition();
}

TEST(Recorder, WritesOnItsOwnThreadEvenWhenTheServoPauses) {
    const auto file = fresh_folder("recorder_thread") / "a.rec";
    SampleRing<servo::ServoSample> ring(1024);
    Recorder recorder(ring);
    recorder.start(file, record_header(10'000.0), Mode::own_thread);
    push(ring, 0, 7); // far less than a chunk of 200
    EXPECT_TRUE(comes_true([&] { return recorder.status().rows == 7; }));
    EXPECT_EQ(recorder.status().bytes, std::filesystem::file_size(file));
    recorder.note("paused");
    EXPECT_TRUE(comes_true(
        [&] { return recorder.status().bytes > expected_bytes(7, record_header(10'000.0)); }));
    push(ring, 7, 9);
    recorder.stop("end");
    EXPECT_EQ(log_of(file), "0 1 2 3 4 5 6 {paused} 7 8 {end} ");
}

// For the thread sanitizer: calls everything that may run concurrently.
TEST(Recorder, MayBeQueriedByAnyThread) {
    const auto file = fresh_folder("recorder_threads") / "a.rec";
    SampleRing<servo::ServoSample> ring(1U << 12U);
    Recorder recorder(ring);
    recorder.start(file, record_header(10'000.0), Mode::own_thread);
    std::atomic<bool> pushed{false};
    std::thread servo([&] {
        for (std::uint64_t tick = 0; tick < 5000; ++tick) {
            while (!ring.push(sample_at(tick))) {
                std::this_thread::yield();
            }
        }
        pushed = true;
    });
    std::uint64_t rows = 0;
    std::size_t notes = 0;
    while (!pushed) {
        const RecorderStatus status = recorder.status();
        EXPECT_GE(status.rows, rows);
        rows = status.rows;
        EXPECT_TRUE(recorder.is_recording());
        recorder.note("n");
        ++notes;
        std::this_thread::sleep_for(std::chrono::microseconds(300));
    }
    servo.join();
    recorder.stop();
    EXPECT_EQ(recorder.status().rows, 5000U);
    RecordReader reader(file);
    while (reader.next()) {
    }
    EXPECT_EQ(reader.ending().rows, 5000U);
    EXPECT_EQ(reader.ending().notes, notes);
    EXPECT_EQ(reader.ending().missing_ticks, 0U);
}

} // namespace
} // namespace springdrive::record
