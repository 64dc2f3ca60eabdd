// Covers engine/record/record_file.cpp: for any file, also a damaged one, reading ends with the
// rows before the damage or one clear message.
#include "engine/record/record_file.h"

#include "engine/record/recorder.h"

#include "tests/engine/record/samples.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <sys/mount.h>
#include <sys/resource.h>

namespace springdrive::record {
namespace {

using testing::bytes_of_number;
using testing::chunk_bytes;
using testing::contents_of;
using testing::expected_bytes;
using testing::fresh_folder;
using testing::FullDisk;
using testing::header_bytes;
using testing::random_samples;
using testing::row_of;
using testing::take_apart;
using testing::write_file;

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

/// Rows that nobody will find are not counted as kept.
TEST(RecordWriter, EndsInAnErrorWhenItsFileOrFolderGoesAway) {
    const RecordHeader header = record_header(testing::kServo_hz);
    const auto folder = fresh_folder("record_gone") / "inner";
    const auto file = folder / "a.rec";
    const std::array<std::function<void()>, 4> ways{
        [] {},
        [&] { std::filesystem::remove(file); },
        [&] { std::filesystem::remove_all(folder); },
        [&] { std::filesystem::rename(folder, folder.parent_path() / "elsewhere"); },
    };
    for (std::size_t way = 0; way < ways.size(); ++way) {
        std::filesystem::create_directories(folder);
        RecordWriter writer(file, header, Existing::replace);
        const auto write = [&] {
            return error_text_of([&] {
                for (int i = 0; i < 100; ++i) {
                    writer.write({});
                }
                writer.close();
            });
        };
        ways[way]();
        const std::string said = way % 2 == 0 ? write() : error_text_of([&] { writer.close(); });
        EXPECT_EQ(said.empty(), way == 0) << said;
        EXPECT_EQ(said.find(file.string() + ": the recording ends: "), way == 0 ? said.npos : 0U);
        EXPECT_FALSE(writer.is_open());
        EXPECT_EQ(write(), "") << "it is said once";
    }
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

std::vector<std::string> rows_of(RecordReader &reader) {
    std::vector<std::string> rows;
    reader.for_each([&](const servo::ServoSample &sample) { rows.push_back(row_of(sample)); });
    return rows;
}

TEST(RecordReader, ReturnsEverySample) {
    const auto file = fresh_folder("reader_all") / "a.rec";
    const auto samples = random_samples(103, testing::kServo_hz, 1);
    testing::write_record(file, testing::kServo_hz, samples);
    RecordReader reader(file);
    EXPECT_EQ(to_json(reader.header()), testing::take_apart(contents_of(file)).json);
    for (int round = 0; round < 2; ++round) {
        const auto rows = rows_of(reader);
        ASSERT_EQ(rows.size(), samples.size());
        for (std::size_t i = 0; i < rows.size(); ++i) {
            EXPECT_EQ(rows[i], row_of(samples[i])) << i;
        }
        EXPECT_EQ(reader.ending().text(), "103 rows");
        EXPECT_FALSE(reader.next());
        reader.rewind();
    }
}

TEST(RecordReader, ReturnsNotesBetweenTheRows) {
    const auto file = fresh_folder("reader_notes") / "a.rec";
    {
        RecordWriter writer(file, record_header(testing::kServo_hz));
        writer.write(random_samples(1, testing::kServo_hz, 2)[0]);
        writer.note("one");
        writer.note("");
    }
    RecordReader reader(file);
    const struct {
        bool is_note;
        std::uint32_t rows;
        const char *note;
    } chunks[]{{false, 1, ""}, {true, 0, "one"}, {true, 0, ""}};
    for (const auto &chunk : chunks) {
        ASSERT_TRUE(reader.next());
        EXPECT_EQ(reader.is_note(), chunk.is_note);
        EXPECT_EQ(reader.rows(), chunk.rows);
        EXPECT_EQ(reader.note(), chunk.note);
    }
    EXPECT_FALSE(reader.next());
    EXPECT_EQ(reader.ending().text(), "1 row, 2 notes");
}

TEST(RecordReader, CountsMissingTicks) {
    const auto file = fresh_folder("reader_missing") / "a.rec";
    auto samples = random_samples(10, testing::kServo_hz, 3);
    const std::vector<std::uint64_t> ticks{100, 101, 103, 104, 105, 110, 111, 112, 5, 7};
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        samples[i].tick = ticks[i];
    }
    testing::write_record(file, testing::kServo_hz, samples);
    RecordReader reader(file);
    EXPECT_EQ(rows_of(reader).size(), 10U);
    EXPECT_EQ(reader.ending().missing_ticks, 1U + 4U + 1U); // also between chunks
    EXPECT_EQ(reader.ending().text(), "10 rows; 6 samples lost between them");
}

/// The text of the ending after reading all of `bytes`.
std::string ending_of(const std::filesystem::path &file, const std::string &bytes) {
    write_file(file, bytes);
    RecordReader reader(file);
    static_cast<void>(rows_of(reader));
    return reader.ending().text();
}

class DamagedRecord : public ::testing::Test {
protected:
    void SetUp() override {
        testing::write_record(file, testing::kServo_hz, random_samples(15, testing::kServo_hz, 4));
        bytes = contents_of(file);
        chunks = testing::take_apart(bytes).chunks;
    }

    std::filesystem::path file = fresh_folder("reader_damaged") / "a.rec";
    std::string bytes;
    std::vector<testing::ChunkBytes> chunks;
};

TEST_F(DamagedRecord, IsReadUpToATruncatedChunk) {
    const std::size_t last = chunks[2].at;
    EXPECT_EQ(ending_of(file, bytes.substr(0, last)), "10 rows");
    for (const std::size_t left : {std::size_t{1}, std::size_t{27}, std::size_t{28},
                                   std::size_t{29}, bytes.size() - last - 1}) {
        EXPECT_EQ(ending_of(file, bytes.substr(0, last + left)),
                  "10 rows; the last " + std::to_string(left) + (left == 1 ? " byte" : " bytes") +
                      " of the file cannot be used: the last chunk is incomplete");
    }
}

TEST_F(DamagedRecord, IsReadUpToADamagedChunk) {
    const std::string left = std::to_string(bytes.size() - chunks[1].at);
    const auto after_change_at = [&](std::size_t offset) {
        std::string changed = bytes;
        changed[chunks[1].at + offset] ^= 1;
        return ending_of(file, changed);
    };
    const std::string start = "5 rows; the last " + left + " bytes of the file cannot be used: ";
    EXPECT_EQ(after_change_at(0), start + "there is no chunk where one should begin");
    EXPECT_EQ(after_change_at(8), start + "a chunk is damaged (CRC)");
    EXPECT_EQ(after_change_at(16), start + "a chunk's size does not match its rows");
    EXPECT_EQ(after_change_at(23), start + "a chunk's size does not match its rows");
    EXPECT_EQ(after_change_at(24), start + "a chunk is damaged (CRC)");
    EXPECT_EQ(after_change_at(28), start + "a chunk is damaged (CRC)");
    EXPECT_EQ(after_change_at(chunks[2].at - chunks[1].at - 1), start + "a chunk is damaged (CRC)");
}

TEST_F(DamagedRecord, SkipsChunksOfUnknownKinds) {
    const std::string with = bytes.substr(0, chunks[1].at) + chunk_bytes(7, 1, 2, "what is this") +
                             bytes.substr(chunks[1].at);
    EXPECT_EQ(ending_of(file, with), "15 rows");
}

TEST_F(DamagedRecord, EndsAtAChunkOfTheWrongSize) {
    const std::string header = bytes.substr(0, chunks[0].at);
    const std::string &rows = chunks[0].payload;
    EXPECT_EQ(ending_of(file, header + chunk_bytes(0, 0, 5, rows)), "5 rows");
    for (const auto &chunk : {chunk_bytes(0, 0, 4, rows), chunk_bytes(0, 0, 0, ""),
                              chunk_bytes(0, 0, 6, rows + rows.substr(0, rows.size() / 5))}) {
        EXPECT_EQ(ending_of(file, header + chunk),
                  "0 rows; the last " + std::to_string(chunk.size()) +
                      " bytes of the file cannot be used: a chunk's size does not match its rows");
    }
}

TEST_F(DamagedRecord, IsReadUpToItsEndIfItShrinksMeanwhile) {
    RecordReader reader(file);
    std::filesystem::resize_file(file, chunks[2].at + 100);
    EXPECT_EQ(rows_of(reader).size(), 10U);
    EXPECT_EQ(reader.ending().why, "the file cannot be read further");
}

TEST(RecordReader, RejectsFilesThatAreNotRecords) {
    const auto folder = fresh_folder("reader_refused");
    const auto file = folder / "a.rec";
    const std::string good = header_bytes(to_json(record_header(testing::kServo_hz)));
    write_file(file, good);
    EXPECT_NO_THROW(RecordReader{file});
    std::string later = good;
    later[7] = '2';
    std::string damaged = good;
    damaged[100] ^= 1;
    const std::size_t deep = 500'000;
    const std::vector<std::pair<std::string, std::string>> cases{
        {"", "is not a springdrive record"},
        {"tick,time_s\n0,0\n", "is not a springdrive record"},
        {later, "layout that this version does not know"},
        {good.substr(0, good.size() - 1), "incomplete"},
        {good.substr(0, 12), "incomplete"},
        {header_bytes("{}"), "its header does not say"},
        {header_bytes(std::string(deep, '[') + std::string(deep, ']')), "not a JSON object"},
        {header_bytes(std::string(2 * deep, '[')), "not a JSON object"},
        {damaged, "damaged (CRC)"}};
    for (const auto &[bytes, said] : cases) {
        write_file(file, bytes);
        const std::string text = error_text_of([&] { RecordReader{file}; });
        EXPECT_EQ(text.find(file.string() + ": "), 0U) << text;
        EXPECT_NE(text.find(said), std::string::npos) << text;
    }
    EXPECT_NE(error_text_of([&] { RecordReader{folder}; }).find("not a regular file"),
              std::string::npos);
    EXPECT_NE(error_text_of([&] { RecordReader{folder / "none"}; }).find("cannot be read"),
              std::string::npos);
}

TEST(RecordReader, NamesTheFileWhenAColumnOfASampleIsMissing) {
    const auto file = fresh_folder("reader_missing_column") / "a.rec";
    write_file(file, header_bytes(R"({"format": "springdrive record 1", "period_s": 0.001,
        "row_bytes": 1, "chunk_rows": 9, "columns": [{"name": "a", "type": "|u1"}]})") +
                         chunk_bytes(0, 0, 2, "ab"));
    RecordReader reader(file);
    ASSERT_TRUE(reader.next());
    EXPECT_EQ(static_cast<char>(reader.row(1)[0]), 'b');
    const std::string said = error_text_of([&] { (void)reader.read_sample(0); });
    EXPECT_EQ(said.find(file.string() + ": the record has no column tick"), 0U) << said;
}

std::int64_t max_memory_kB() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
}

// The file says that it is 8 GB large, and its heads that all of it is one note or chunk.
TEST(RecordReader, AllocatesLittleMemoryForAnyClaimedLength) {
    const auto file = fresh_folder("reader_memory") / "a.rec";
    const std::int64_t before_kB = max_memory_kB();
    std::string header = header_bytes(to_json(record_header(testing::kServo_hz)));
    std::string head = chunk_bytes(1, 0, 0, "");
    for (const std::uint64_t claimed : {0xFFFFFFFFU, 0x80000000U, (64U << 20U) + 1}) {
        head.replace(20, 4, testing::bytes_of_number(claimed, 4));
        write_file(file, header + head);
        std::filesystem::resize_file(file, std::uintmax_t{8} << 30U);
        RecordReader reader(file);
        EXPECT_FALSE(reader.next());
        EXPECT_NE(reader.ending().why.find("exceeds the maximum"), std::string::npos);
    }
    header.replace(8, 4, testing::bytes_of_number(0xFFFFFFFFU, 4));
    write_file(file, header);
    std::filesystem::resize_file(file, std::uintmax_t{8} << 30U);
    EXPECT_NE(error_text_of([&] { RecordReader{file}; }), "");
    EXPECT_LT(max_memory_kB() - before_kB, 50'000);
}

std::string good_record() {
    const auto file = testing::fresh_folder("fuzz_good") / "a.rec";
    RecordWriter writer(file, record_header(testing::kServo_hz));
    const auto samples = testing::random_samples(13, testing::kServo_hz, 1);
    for (const servo::ServoSample &sample : samples) {
        writer.write(sample);
        if (sample.tick == 6) {
            writer.note(R"({"scene": "sphere.gltf"})");
        }
    }
    writer.close();
    return testing::contents_of(file);
}

/// Outcome of reading. Rows are compared with those of the intact file.
struct Outcome {
    bool refused = false;
    std::uint64_t rows = 0;
};

class RecordFuzz : public ::testing::Test {
protected:
    Outcome read(const std::string &bytes, bool rows_are_good) {
        testing::write_file(file, bytes);
        Outcome outcome;
        try {
            RecordReader reader(file);
            std::uint64_t usable = 0;
            while (reader.next()) {
                usable += 28 + reader.note().size() +
                          std::uint64_t{reader.rows()} * reader.header().row_bytes;
                for (std::uint32_t i = 0; i < reader.rows(); ++i) {
                    look_at(reader, i, rows_are_good ? outcome.rows : ~std::uint64_t{0});
                    ++outcome.rows;
                }
            }
            EXPECT_EQ(reader.ending().rows, outcome.rows);
            EXPECT_LE(usable + reader.ending().unusable_bytes, bytes.size());
            EXPECT_EQ(reader.ending().why.empty(), reader.ending().unusable_bytes == 0);
        } catch (const InputError &error) {
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
            outcome.refused = true;
        }
        return outcome;
    }

    void look_at(RecordReader &reader, std::uint32_t row, std::uint64_t number) {
        const std::string sample = testing::row_of(reader.read_sample(row));
        if (number < samples.size()) {
            EXPECT_EQ(sample, testing::row_of(samples[number]));
        }
    }

    std::size_t below(std::size_t limit) {
        return std::uniform_int_distribution<std::size_t>(0, limit - 1)(random);
    }

    std::mt19937_64 random{20};
    std::filesystem::path file = testing::fresh_folder("fuzz") / "a.rec";
    std::vector<servo::ServoSample> samples = testing::random_samples(13, testing::kServo_hz, 1);
    std::string good = good_record();
    testing::RecordBytes parts = testing::take_apart(good);
};

TEST_F(RecordFuzz, SurvivesACutAnywhere) {
    const std::size_t header_end = parts.chunks[0].at;
    for (std::size_t i = 0; i < 700; ++i) {
        // Lengths near the boundaries of the parts, and random ones.
        const auto &chunk = parts.chunks[i % parts.chunks.size()];
        const std::size_t length = i < 300
                                       ? std::min(good.size(), chunk.at + i / parts.chunks.size())
                                   : i < 340 ? i - 300
                                             : below(good.size());
        const Outcome outcome = read(good.substr(0, length), true);
        EXPECT_EQ(outcome.refused, length < header_end) << length;
        std::uint64_t whole = 0;
        for (const auto &c : parts.chunks) {
            whole += c.at + 28 + c.payload.size() <= length ? c.rows : 0;
        }
        EXPECT_EQ(outcome.rows, whole) << length;
    }
}

TEST_F(RecordFuzz, FindsEveryFlippedBit) {
    const std::size_t header_end = parts.chunks[0].at;
    for (std::size_t i = 0; i < 1500; ++i) {
        // Heads and the beginning of the file are small, so they are targeted.
        const auto &chunk = parts.chunks[below(parts.chunks.size())];
        const std::size_t at = i % 3 == 0   ? below(16)
                               : i % 3 == 1 ? chunk.at + below(40)
                                            : below(good.size());
        std::string damaged = good;
        damaged[at] = static_cast<char>(damaged[at] ^ (1 << below(8)));
        const Outcome outcome = read(damaged, true);
        EXPECT_EQ(outcome.refused, at < header_end) << at;
        std::uint64_t before = 0;
        for (const auto &c : parts.chunks) {
            before += c.at + 28 + c.payload.size() <= at ? c.rows : 0;
        }
        EXPECT_EQ(outcome.rows, at < header_end ? 0 : before) << at;
    }
}

// Malicious damage has a valid CRC.
TEST_F(RecordFuzz, SurvivesDamageWithAValidCrc) {
    for (int i = 0; i < 800; ++i) {
        std::string text = parts.json;
        const std::size_t changes = 1 + below(3);
        for (std::size_t c = 0; i % 2 == 0 && c < changes; ++c) {
            text[below(text.size())] = static_cast<char>(below(256));
        }
        std::string bytes = testing::header_bytes(text);
        for (const auto &chunk : parts.chunks) {
            std::string payload = chunk.payload;
            if (i % 2 == 1 && !payload.empty()) {
                payload[below(payload.size())] = static_cast<char>(below(256));
            }
            const std::uint64_t kind = below(4) == 0 ? below(3) : chunk.kind;
            const std::uint64_t rows = below(6) == 0 ? below(8) : chunk.rows;
            bytes += testing::chunk_bytes(kind, random(), rows, payload);
        }
        static_cast<void>(read(bytes, false));
    }
}

TEST_F(RecordFuzz, SurvivesFalseLengths) {
    const std::vector<std::uint64_t> lies{0,          1,          27,         0x7FFFFFFF,
                                          0x80000000, 0xFFFFFFFF, 0xFFFFFFE4, good.size()};
    for (const std::uint64_t lie : lies) {
        std::string damaged = good;
        EXPECT_TRUE(read(damaged.replace(8, 4, bytes_of_number(lie, 4)), true).refused) << lie;
        for (const auto &chunk : parts.chunks) {
            for (const std::size_t field : {16U, 20U}) {
                damaged = good;
                damaged.replace(chunk.at + field, 4, bytes_of_number(lie, 4));
                static_cast<void>(read(damaged, true));
            }
        }
    }
}

TEST_F(RecordFuzz, SurvivesFilesThatAreNotRecords) {
    for (int i = 0; i < 200; ++i) {
        std::string noise(below(200), '\0');
        for (char &byte : noise) {
            byte = static_cast<char>(below(256));
        }
        EXPECT_TRUE(read(noise, false).refused);
        EXPECT_TRUE(read("SPRDREC1" + noise, false).refused);
        EXPECT_EQ(read(good + "CHNK" + noise, false).rows, 13U);
    }
}

} // namespace
} // namespace springdrive::record
