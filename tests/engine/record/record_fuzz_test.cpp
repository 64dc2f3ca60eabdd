// Covers engine/record/record_reader.cpp: for any damaged file, reading ends with the rows before
// the damage or one clear message.
#include "engine/record/record_reader.h"

#include "engine/record/record_export.h"
#include "tests/engine/record/record_bytes.h"
#include "tests/engine/record/samples.h"

#include <gtest/gtest.h>

#include <functional>
#include <sstream>

namespace springdrive::record {
namespace {

using testing::bytes_of_number;

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
    for (std::size_t i = 0; i < 1500; ++i) {
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
    for (std::size_t i = 0; i < 3000; ++i) {
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
    for (int i = 0; i < 1500; ++i) {
        std::string json = parts.json;
        const std::size_t changes = 1 + below(3);
        for (std::size_t c = 0; i % 2 == 0 && c < changes; ++c) {
            json[below(json.size())] = static_cast<char>(below(256));
        }
        std::string bytes = testing::header_bytes(json);
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
    for (int i = 0; i < 500; ++i) {
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
