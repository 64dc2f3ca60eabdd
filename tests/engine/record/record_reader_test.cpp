// Covers engine/record/record_reader.cpp; damage of every kind: record_fuzz_test.cpp.
#include "engine/record/record_reader.h"

#include "tests/engine/record/record_bytes.h"
#include "tests/engine/record/samples.h"

#include <gtest/gtest.h>

#include <sys/resource.h>

namespace springdrive::record {
namespace {

using testing::chunk_bytes;
using testing::contents_of;
using testing::error_text_of;
using testing::fresh_folder;
using testing::header_bytes;
using testing::random_samples;
using testing::row_of;
using testing::write_file;

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
    ASSERT_TRUE(reader.next());
    EXPECT_FALSE(reader.is_note());
    EXPECT_EQ(reader.rows(), 1U);
    EXPECT_EQ(reader.note(), "");
    ASSERT_TRUE(reader.next());
    EXPECT_TRUE(reader.is_note());
    EXPECT_EQ(reader.note(), "one");
    EXPECT_EQ(reader.rows(), 0U);
    ASSERT_TRUE(reader.next());
    EXPECT_TRUE(reader.is_note());
    EXPECT_EQ(reader.note(), "");
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

TEST(RecordReader, RejectsFilesThatAreNotRecords) {
    const auto folder = fresh_folder("reader_refused");
    const auto file = folder / "a.rec";
    const auto said = [&](const std::string &bytes) {
        write_file(file, bytes);
        const std::string text = error_text_of([&] { RecordReader{file}; });
        EXPECT_EQ(text.find(file.string() + ": "), 0U) << text;
        return text;
    };
    const std::string good = header_bytes(to_json(record_header(testing::kServo_hz)));
    write_file(file, good);
    EXPECT_NO_THROW(RecordReader{file});
    EXPECT_NE(said("").find("is not a springdrive record"), std::string::npos);
    EXPECT_NE(said("tick,time_s\n0,0\n").find("is not a springdrive record"), std::string::npos);
    std::string later = good;
    later[7] = '2';
    EXPECT_NE(said(later).find("layout that this version does not know"), std::string::npos);
    EXPECT_NE(said(good.substr(0, good.size() - 1)).find("incomplete"), std::string::npos);
    EXPECT_NE(said(good.substr(0, 12)).find("incomplete"), std::string::npos);
    EXPECT_NE(said(header_bytes("{}")).find("its header does not say"), std::string::npos);
    std::string damaged = good;
    damaged[100] ^= 1;
    EXPECT_NE(said(damaged).find("damaged (CRC)"), std::string::npos);
    EXPECT_NE(error_text_of([&] { RecordReader{folder}; }).find("not a regular file"),
              std::string::npos);
    EXPECT_NE(error_text_of([&] { RecordReader{folder / "none"}; }).find("cannot be read"),
              std::string::npos);
}

TEST(RecordReader, RejectsAnEndlesslyNestedHeader) {
    const auto file = fresh_folder("reader_nested") / "a.rec";
    for (const std::size_t depth : {std::size_t{500'000}, std::size_t{1} << 20U}) {
        write_file(file, header_bytes(std::string(depth, '[') +
                                      (depth == 500'000 ? std::string(depth, ']') : "")));
        EXPECT_NE(error_text_of([&] { RecordReader{file}; }).find("not a JSON object"),
                  std::string::npos);
    }
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

} // namespace
} // namespace springdrive::record
