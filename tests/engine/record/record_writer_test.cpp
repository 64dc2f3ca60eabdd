// Covers engine/record/record_writer.cpp, except for full disks: record_full_disk_test.cpp.
#include "engine/record/record_writer.h"

#include "tests/engine/record/record_bytes.h"
#include "tests/engine/record/samples.h"
#include "tests/support/modes.h"

#include <gtest/gtest.h>

namespace springdrive::record {
namespace {

using testing::contents_of;
using testing::error_text_of;
using testing::fresh_folder;
using testing::random_samples;
using testing::row_of;
using testing::take_apart;

TEST(RecordWriter, WritesTheDocumentedFormat) {
    const auto file = fresh_folder("writer_layout") / "a.rec";
    const auto samples = random_samples(13, testing::kServo_hz, 1);
    testing::write_record(file, testing::kServo_hz, samples);
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

TEST(RecordWriter, PredictsTheSize) {
    const auto folder = fresh_folder("writer_size");
    for (const double rate : {1.0, 250.0, 1000.0, 4321.0}) {
        const RecordHeader header = record_header(rate);
        for (const std::size_t rows : {0U, 1U, 4U, 5U, 6U, 19U, 20U, 21U, 100U}) {
            const auto file = folder / (std::to_string(rate) + "_" + std::to_string(rows));
            RecordWriter writer(file, header);
            for (const servo::ServoSample &sample : random_samples(rows, rate, rows)) {
                writer.write(sample);
            }
            writer.close();
            EXPECT_EQ(std::filesystem::file_size(file), expected_bytes(rows, header)) << file;
        }
    }
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
                writer.note("{}");
            }
        }
    } // the destructor closes
    const auto record = take_apart(contents_of(file));
    ASSERT_EQ(record.chunks.size(), 5U);
    EXPECT_EQ(record.chunks[0].kind, 1U);
    EXPECT_EQ(record.chunks[0].payload, R"({"scene": "sphere"})");
    EXPECT_EQ(record.chunks[1].rows, 5U);
    EXPECT_EQ(record.chunks[2].rows, 1U);
    EXPECT_EQ(record.chunks[3].payload, "{}");
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

TEST(RecordWriter, NeverReplacesAFile) {
    const auto file = fresh_folder("writer_exists") / "a.rec";
    testing::write_file(file, "precious");
    const std::string said =
        error_text_of([&] { RecordWriter(file, record_header(testing::kServo_hz)); });
    EXPECT_EQ(said, file.string() + ": exists already; give another name");
    EXPECT_EQ(contents_of(file), "precious");
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

TEST(RecordWriter, ReportsAMissingFolder) {
    const auto file = fresh_folder("writer_folder") / "none" / "a.rec";
    const std::string said =
        error_text_of([&] { RecordWriter(file, record_header(testing::kServo_hz)); });
    EXPECT_NE(said.find(file.string() + ": cannot be written: No such file"), std::string::npos)
        << said;
}

TEST(RecordWriter, RefusesTheHeaderOfAnotherVersion) {
    const auto file = fresh_folder("writer_version") / "a.rec";
    RecordHeader header = record_header(testing::kServo_hz);
    header.columns.pop_back();
    EXPECT_NE(error_text_of([&] { RecordWriter(file, header); }), "");
    EXPECT_FALSE(std::filesystem::exists(file));
}

TEST(RecordWriter, RejectsAHeaderThatReadersWouldReject) {
    const auto file = fresh_folder("writer_header") / "a.rec";
    RecordHeader header = record_header(testing::kServo_hz);
    header.device_toml = std::string(std::size_t{2} << 20U, 'x');
    EXPECT_NE(error_text_of([&] { RecordWriter(file, header); }), "");
    EXPECT_FALSE(std::filesystem::exists(file));
}

} // namespace
} // namespace springdrive::record
