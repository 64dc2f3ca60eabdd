// Covers engine/record/record_writer.cpp and recorder.cpp on full disks.
#include "engine/record/recorder.h"

#include "engine/record/record_reader.h"
#include "tests/engine/record/samples.h"

#include <gtest/gtest.h>

#include <csignal>
#include <functional>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace springdrive::record {
namespace {

using testing::contents_of;
using testing::error_text_of;
using testing::fresh_folder;

/// Runs `step` in a process whose files cannot grow beyond `bytes`, and returns its message.
std::string with_files_up_to(std::uint64_t bytes, const std::filesystem::path &folder,
                             const std::function<std::string()> &step) {
    const pid_t child = fork();
    if (child == 0) {
        std::signal(SIGXFSZ, SIG_IGN);
        rlimit limit{};
        getrlimit(RLIMIT_FSIZE, &limit);
        limit.rlim_cur = bytes;
        setrlimit(RLIMIT_FSIZE, &limit);
        const std::string said = step();
        testing::write_file(folder / "said", said.substr(0, bytes));
        _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    return contents_of(folder / "said");
}

std::uint64_t rows_in(const std::filesystem::path &file) {
    RecordReader reader(file);
    while (reader.next()) {
    }
    EXPECT_EQ(reader.ending().why, "");
    return reader.ending().rows;
}

/// Writes until it fails; then continues, which must do nothing.
std::string write_until_full(const std::filesystem::path &file) {
    RecordWriter writer(file, record_header(testing::kServo_hz));
    servo::ServoSample sample;
    const std::string said = error_text_of([&] {
        for (; sample.tick < 100'000; ++sample.tick) {
            writer.write(sample);
        }
    });
    const std::string again = error_text_of([&] {
        for (int i = 0; i < 20; ++i) {
            writer.write(sample);
        }
        writer.note("{}");
        writer.flush();
        writer.close();
    });
    return said + again + (writer.is_open() ? " still open" : "");
}

TEST(FullDisk, EndsTheFileAtItsLastCompleteChunkAndReportsOnce) {
    const RecordHeader header = record_header(testing::kServo_hz);
    // After two chunks, zero bytes, one byte, and all but one byte of a chunk fit.
    for (const std::uint64_t more : {std::uint64_t{0}, std::uint64_t{1},
                                     expected_bytes(5, header) - expected_bytes(0, header) - 1}) {
        const auto folder = fresh_folder("full_disk");
        const auto file = folder / "a.rec";
        const std::string said = with_files_up_to(expected_bytes(10, header) + more, folder,
                                                  [&] { return write_until_full(file); });
        EXPECT_EQ(said, file.string() + ": the recording ends after 10 rows, which are kept: File "
                                        "too large; free disk space or choose another folder");
        EXPECT_EQ(std::filesystem::file_size(file), expected_bytes(10, header));
        EXPECT_EQ(rows_in(file), 10U);
    }
}

TEST(FullDisk, LeavesNoFileIfTheHeaderDoesNotFit) {
    const auto folder = fresh_folder("full_disk_header");
    const auto file = folder / "a.rec";
    const std::string said = with_files_up_to(1000, folder, [&] {
        return error_text_of([&] { RecordWriter(file, record_header(testing::kServo_hz)); });
    });
    EXPECT_EQ(said, file.string() + ": cannot be written: File too large; nothing was recorded");
    EXPECT_FALSE(std::filesystem::exists(file));
}

TEST(FullDisk, RefusesAnExistingDeviceFile) {
    const std::string said =
        error_text_of([] { RecordWriter("/dev/full", record_header(testing::kServo_hz)); });
    EXPECT_EQ(said, "/dev/full: exists already; give another name");
}

std::uint64_t g_pushed_while_full = 0;

/// Fills the disk through a recorder; then pushes 100 more full rings, each of which must be
/// drained.
std::string record_until_full(const std::filesystem::path &file) {
    SampleRing<servo::ServoSample> ring(16);
    Recorder recorder(ring);
    recorder.start(file, record_header(testing::kServo_hz), Recorder::Mode::pumped);
    servo::ServoSample sample;
    const auto push_and_pump = [&] {
        for (int i = 0; i < 16; ++i, ++sample.tick) {
            g_pushed_while_full += ring.push(sample) ? 1 : 0;
        }
        recorder.pump();
    };
    while (recorder.is_recording() && sample.tick < 100'000) {
        push_and_pump();
    }
    g_pushed_while_full = 0;
    for (int i = 0; i < 100; ++i) {
        push_and_pump();
    }
    const RecorderStatus status = recorder.status();
    recorder.stop("{}");
    const bool is_the_same = recorder.status().error == status.error;
    return status.error + (is_the_same ? " [" : " and another error [") +
           std::to_string(status.rows) + " rows, " + std::to_string(status.bytes) + " bytes, " +
           std::to_string(g_pushed_while_full) + " pushed]";
}

TEST(FullDisk, EndsTheRecordingButNotTheDraining) {
    const auto folder = fresh_folder("full_disk_recorder");
    const auto file = folder / "a.rec";
    const RecordHeader header = record_header(testing::kServo_hz);
    const std::string said = with_files_up_to(expected_bytes(25, header) + 7, folder,
                                              [&] { return record_until_full(file); });
    EXPECT_EQ(said, file.string() +
                        ": the recording ends after 25 rows, which are kept: File too large; free "
                        "disk space or choose another folder [25 rows, " +
                        std::to_string(expected_bytes(25, header)) + " bytes, 1600 pushed]");
    EXPECT_EQ(rows_in(file), 25U);
}

TEST(FullDisk, KeepsWhatFitsOnARealFileSystem) {
    const auto folder = fresh_folder("full_disk_real");
    if (mount("none", folder.c_str(), "tmpfs", 0, "size=1m") != 0) {
        GTEST_SKIP() << "mounting a small disk takes root";
    }
    const auto file = folder / "a.rec";
    const std::string said = write_until_full(file);
    const std::uint64_t rows = std::filesystem::exists(file) ? rows_in(file) : 0;
    umount(folder.c_str());
    EXPECT_EQ(said, file.string() + ": the recording ends after " + std::to_string(rows) +
                        " rows, which are kept: No space left on device; free disk space or choose "
                        "another folder");
    const RecordHeader header = record_header(testing::kServo_hz);
    EXPECT_LE(expected_bytes(rows, header), std::uint64_t{1} << 20U);
    EXPECT_GT(expected_bytes(rows + 10, header), (std::uint64_t{1} << 20U) - 4096);
}

} // namespace
} // namespace springdrive::record
