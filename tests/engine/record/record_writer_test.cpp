// Covers engine/record/record_writer.cpp, and recorder.cpp on full disks.
#include "engine/record/record_writer.h"

#include "engine/record/record_reader.h"
#include "engine/record/recorder.h"
#include "tests/engine/record/record_bytes.h"
#include "tests/engine/record/samples.h"
#include "tests/support/full_disk.h"
#include "tests/support/modes.h"

#include <gtest/gtest.h>

#include <sys/mount.h>

namespace springdrive::record {
namespace {

using testing::contents_of;
using testing::error_text_of;
using testing::expected_bytes;
using testing::fresh_folder;
using testing::FullDisk;
using testing::random_samples;
using testing::row_of;
using testing::take_apart;

TEST(RecordWriter, WritesTheDocumentedFormat) {
    const auto file = fresh_folder("writer_layout") / "a.rec";
    const auto samples = random_samples(13, testing::kServo_hz, 1);
    testing::write_record(file, testing::kServo_hz, samples);
    EXPECT_EQ(testing::slow_crc32("123456789"), 0xCBF43926U); // the published check value
    const auto record = take_apart(contents_of(file));
    EXPECT_EQ(from_json(record.json).columns, record_header(testing::kServo_hz).columns);
    ASSERT_EQ(record.chunks.size(), 3U);
    std::string rows;
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(record.chunks[i].kind, 0U);
        EXPECT_EQ(record.chunks[i].first_tick, 5 * i);
        EXPECT_EQ(record.chunks[i].rows, i < 2 ? 5U : 3U);
        rows += record.chunks[i].payload;
    }
    std::string expected;
    for (const servo::ServoSample &sample : samples) {
        expected += row_of(sample);
    }
    EXPECT_EQ(rows, expected);
}

TEST(RecordWriter, OfPersonalDataIsItsOwnersAlone) {
    const testing::Umask umask(0022);
    const auto folder = fresh_folder("writer_modes");
    const RecordHeader header = record_header(testing::kServo_hz);
    for (const Existing existing : {Existing::keep, Existing::replace}) {
        RecordWriter(folder / "all.rec", header, existing).close();
        RecordWriter(folder / "own.rec", header, {existing, Readers::owner}).close();
        EXPECT_EQ(testing::mode_of(folder / "all.rec"), 0644U);
        EXPECT_EQ(testing::mode_of(folder / "own.rec"), 0600U);
        std::filesystem::remove(folder / "all.rec");
        std::filesystem::remove(folder / "own.rec");
    }
}

TEST(RecordWriter, WritesAChunkAsSoonAsItIsFullAndNoSooner) {
    const auto file = fresh_folder("writer_chunks") / "a.rec";
    const RecordHeader header = record_header(testing::kServo_hz);
    RecordWriter writer(file, header);
    const auto samples = random_samples(12, testing::kServo_hz, 2);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        writer.write(samples[i]);
        const std::size_t in_file = (i + 1) / 5 * 5;
        EXPECT_EQ(std::filesystem::file_size(file), expected_bytes(in_file, header));
        EXPECT_EQ(writer.bytes_in_file(), expected_bytes(in_file, header));
        EXPECT_EQ(writer.rows_in_file(), in_file);
        EXPECT_EQ(writer.rows_waiting(), (i + 1) % 5);
    }
    writer.flush();
    EXPECT_EQ(writer.rows_in_file(), 12U);
    const auto size = std::filesystem::file_size(file);
    EXPECT_EQ(size, expected_bytes(12, header));
    writer.flush();
    writer.close();
    writer.close();
    EXPECT_FALSE(writer.is_open());
    EXPECT_EQ(std::filesystem::file_size(file), size);
}

TEST(RecordWriter, WritesNotesBetweenTheRowsInOrder) {
    const auto file = fresh_folder("writer_notes") / "a.rec";
    {
        RecordWriter writer(file, record_header(testing::kServo_hz));
        const auto samples = random_samples(7, testing::kServo_hz, 3);
        writer.note(R"({"scene": "sphere"})");
        for (std::size_t i = 0; i < 7; ++i) {
            writer.write(samples[i]);
            if (i == 5) {
                writer.note("");
            }
        }
    } // the destructor closes
    const auto record = take_apart(contents_of(file));
    ASSERT_EQ(record.chunks.size(), 5U);
    EXPECT_EQ(record.chunks[0].kind, 1U);
    EXPECT_EQ(record.chunks[0].payload, R"({"scene": "sphere"})");
    EXPECT_EQ(record.chunks[1].rows, 5U);
    EXPECT_EQ(record.chunks[2].rows, 1U);
    EXPECT_EQ(record.chunks[3].payload, "");
    EXPECT_EQ(record.chunks[4].first_tick, 6U);
}

TEST(RecordWriter, RejectsATooLongNoteAndContinues) {
    const auto file = fresh_folder("writer_long_note") / "a.rec";
    RecordWriter writer(file, record_header(testing::kServo_hz));
    writer.note(std::string(RecordWriter::kMaxNote, ' '));
    const std::string said =
        error_text_of([&] { writer.note(std::string(RecordWriter::kMaxNote + 1, ' ')); });
    EXPECT_NE(said.find("too long"), std::string::npos) << said;
    writer.write({});
    writer.close();
    EXPECT_EQ(take_apart(contents_of(file)).chunks.size(), 2U);
}

TEST(RecordWriter, ReplacesAFileIfAskedOnceTheHeaderIsWritten) {
    const auto folder = fresh_folder("writer_replaces");
    const auto file = folder / "a.rec";
    testing::write_file(file, "old");
    RecordHeader header = record_header(testing::kServo_hz);
    header.device_toml = std::string(std::size_t{2} << 20U, 'x');
    EXPECT_NE(error_text_of([&] { RecordWriter(file, header, Existing::replace); }), "");
    EXPECT_EQ(contents_of(file), "old");
    RecordWriter writer(file, record_header(testing::kServo_hz), Existing::replace);
    EXPECT_EQ(take_apart(contents_of(file)).chunks.size(), 0U); // a record, so far without rows
    writer.write({});
    writer.close();
    EXPECT_EQ(take_apart(contents_of(file)).chunks.size(), 1U);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
    EXPECT_EQ(error_text_of([] {
                  RecordWriter("/dev/null", record_header(testing::kServo_hz), Existing::replace);
              }),
              "/dev/null: is not a regular file; give another name");
}

TEST(RecordWriter, RefusesWhatCannotBeReadOrIsNotItsOwn) {
    const auto folder = fresh_folder("writer_refuses");
    testing::write_file(folder / "mine.rec", "precious");
    const RecordHeader good = record_header(testing::kServo_hz);
    RecordHeader other_version = good;
    other_version.columns.pop_back();
    RecordHeader too_long = good;
    too_long.device_toml = std::string(std::size_t{2} << 20U, 'x');
    const struct {
        const char *file;
        const RecordHeader &header;
        const char *said;
    } cases[]{{"mine.rec", good, "mine.rec: exists already; give another name"},
              {"none/a.rec", good, "none/a.rec: cannot be written: No such file"},
              {"a.rec", other_version, "header of another version"},
              {"a.rec", too_long, "larger than 1 MB"}};
    for (const auto &each : cases) {
        const std::string said =
            error_text_of([&] { RecordWriter(folder / each.file, each.header); });
        EXPECT_NE(said.find(each.said), std::string::npos) << said;
    }
    EXPECT_EQ(contents_of(folder / "mine.rec"), "precious");
    EXPECT_FALSE(std::filesystem::exists(folder / "a.rec"));
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
        const auto file = fresh_folder("full_disk") / "a.rec";
        std::string said;
        {
            const FullDisk disk(expected_bytes(10, header) + more);
            said = write_until_full(file);
        }
        EXPECT_EQ(said, file.string() + ": the recording ends after 10 rows, which are kept: File "
                                        "too large; free disk space or choose another folder");
        EXPECT_EQ(std::filesystem::file_size(file), expected_bytes(10, header));
        EXPECT_EQ(rows_in(file), 10U);
    }
}

TEST(FullDisk, LeavesNoFileIfTheHeaderDoesNotFit) {
    const auto file = fresh_folder("full_disk_header") / "a.rec";
    const FullDisk disk(1000);
    EXPECT_EQ(error_text_of([&] { RecordWriter(file, record_header(testing::kServo_hz)); }),
              file.string() + ": cannot be written: File too large; nothing was recorded");
    EXPECT_FALSE(std::filesystem::exists(file));
}

TEST(FullDisk, EndsTheRecordingButNotTheDraining) {
    const auto file = fresh_folder("full_disk_recorder") / "a.rec";
    const RecordHeader header = record_header(testing::kServo_hz);
    const FullDisk disk(expected_bytes(25, header) + 7);
    SampleRing<servo::ServoSample> ring(16);
    Recorder recorder(ring);
    recorder.start(file, header, Recorder::Mode::pumped);
    servo::ServoSample sample;
    const auto push_and_pump = [&] {
        int pushed = 0;
        for (int i = 0; i < 16; ++i, ++sample.tick) {
            pushed += ring.push(sample) ? 1 : 0;
        }
        recorder.pump();
        return pushed;
    };
    while (recorder.is_recording() && sample.tick < 100'000) {
        push_and_pump();
    }
    for (int i = 0; i < 100; ++i) { // full rings, each of which must be drained
        ASSERT_EQ(push_and_pump(), 16);
    }
    const RecorderStatus status = recorder.status();
    recorder.stop("{}");
    EXPECT_EQ(recorder.status().error, status.error);
    EXPECT_EQ(status.error, file.string() + ": the recording ends after 25 rows, which are kept: "
                                            "File too large; free disk space or choose another "
                                            "folder");
    EXPECT_EQ(status.rows, 25U);
    EXPECT_EQ(status.bytes, expected_bytes(25, header));
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
