// Samples and small records for the tests of records, and a parser of record files by their
// documentation alone, without the code under test.
#pragma once

#include "base/input_error.h"
#include "engine/record/record_file.h"
#include "engine/record/record_format.h"
#include "engine/record/telemetry_columns.h"
#include "tests/support/files.h"

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace springdrive::testing {

inline constexpr double kServo_hz = 250.0; ///< 5 rows a chunk

/// Random values in every column, including NaN, −0, subnormal and infinite numbers. Enums have
/// valid values.
inline servo::ServoSample random_sample(std::mt19937_64 &random, std::uint64_t tick) {
    using Limits = std::numeric_limits<double>;
    const std::vector<double> hard{
        Limits::quiet_NaN(), -0.0, Limits::denorm_min(), Limits::infinity(), -Limits::infinity(),
        Limits::max(),       0.1};
    servo::ServoSample sample;
    record::for_each_column(sample, [&](std::string_view, std::string_view, auto &value) {
        using Scalar = std::remove_cvref_t<decltype(value)>;
        const std::uint64_t bits = random();
        if constexpr (std::is_same_v<Scalar, double>) {
            value = bits % 8 == 0 ? hard[bits / 8 % hard.size()]
                                  : std::normal_distribution<double>(0.0, 1e3)(random);
        } else if constexpr (std::is_same_v<Scalar, bool>) {
            value = bits % 2 == 0;
        } else {
            value = static_cast<Scalar>(std::is_enum_v<Scalar> ? bits % 2 : bits);
        }
    });
    sample.tick = tick;
    return sample;
}

/// Its row as bytes, for comparing samples including NaN.
inline std::string row_of(const servo::ServoSample &sample) {
    const std::vector<record::RecordColumn> columns = record::sample_columns();
    std::string row(columns.back().offset + record::bytes_of(columns.back().type), '\0');
    record::encode(sample, reinterpret_cast<std::byte *>(row.data()));
    return row;
}

/// Ticks 0 to n − 1, with time_s = tick × T.
inline std::vector<servo::ServoSample> random_samples(std::size_t count, double servo_hz,
                                                      std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::vector<servo::ServoSample> samples;
    for (std::size_t i = 0; i < count; ++i) {
        samples.push_back(random_sample(random, i));
        samples.back().time_s = static_cast<double>(i) / servo_hz;
    }
    return samples;
}

inline void write_record(const std::filesystem::path &path, double servo_hz,
                         const std::vector<servo::ServoSample> &samples) {
    record::RecordWriter writer(path, record::record_header(servo_hz));
    for (const servo::ServoSample &sample : samples) {
        writer.write(sample);
    }
    writer.close();
}

/// The size of a file of `rows` rows without notes or chunks that ended early.
inline std::uint64_t expected_bytes(std::uint64_t rows, const record::RecordHeader &header) {
    return 8 + 4 + record::to_json(header).size() + 4 + record::bytes_of_rows(rows, header);
}

inline void write_file(const std::filesystem::path &path, const std::string &bytes) {
    std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

// By the documentation of the format alone.

/// Bit by bit, from the polynomial.
inline std::uint32_t slow_crc32(std::string_view bytes) {
    std::uint32_t crc = 0xFFFFFFFFU;
    for (const char byte : bytes) {
        crc ^= static_cast<std::uint8_t>(byte);
        for (int bit = 0; bit < 8; ++bit) {
            crc = (crc >> 1U) ^ (crc % 2 == 1 ? 0xEDB88320U : 0U);
        }
    }
    return ~crc;
}

/// Little endian.
inline std::uint64_t number_at(std::string_view bytes, std::size_t at, std::size_t length) {
    std::uint64_t number = 0;
    for (std::size_t i = length; i-- > 0;) {
        number = number << 8U | static_cast<std::uint8_t>(bytes.at(at + i));
    }
    return number;
}

inline std::string bytes_of_number(std::uint64_t number, std::size_t length) {
    std::string bytes;
    for (std::size_t i = 0; i < length; ++i) {
        bytes += static_cast<char>(number >> (8 * i) & 0xFFU);
    }
    return bytes;
}

struct ChunkBytes {
    std::size_t at = 0; ///< in the file
    std::uint64_t kind = 0;
    std::uint64_t first_tick = 0;
    std::uint64_t rows = 0;
    std::string payload;
};

struct RecordBytes {
    std::string json;
    std::vector<ChunkBytes> chunks;
};

/// @throw std::exception for any byte that is not as documented.
inline RecordBytes take_apart(const std::string &file) {
    const auto insist = [](bool is_so, const char *what) {
        if (!is_so) {
            throw std::runtime_error(what);
        }
    };
    insist(file.substr(0, 8) == "SPRDREC1", "magic");
    RecordBytes record;
    const std::uint64_t length = number_at(file, 8, 4);
    record.json = file.substr(12, length);
    insist(number_at(file, 12 + length, 4) == slow_crc32(record.json), "CRC of the header");
    std::size_t at = 16 + length;
    while (at != file.size()) {
        insist(file.substr(at, 4) == "CHNK", "magic of a chunk");
        const std::uint64_t bytes = number_at(file, at + 20, 4);
        record.chunks.push_back({at, number_at(file, at + 4, 4), number_at(file, at + 8, 8),
                                 number_at(file, at + 16, 4), file.substr(at + 28, bytes)});
        const std::string &payload = record.chunks.back().payload;
        insist(payload.size() == bytes, "length of a chunk");
        insist(number_at(file, at + 24, 4) == slow_crc32(file.substr(at, 24) + payload),
               "CRC of a chunk");
        at += 28 + bytes;
    }
    return record;
}

inline std::string chunk_bytes(std::uint64_t kind, std::uint64_t first_tick, std::uint64_t rows,
                               const std::string &payload) {
    const std::string head = "CHNK" + bytes_of_number(kind, 4) + bytes_of_number(first_tick, 8) +
                             bytes_of_number(rows, 4) + bytes_of_number(payload.size(), 4);
    return head + bytes_of_number(slow_crc32(head + payload), 4) + payload;
}

inline std::string header_bytes(const std::string &json) {
    return "SPRDREC1" + bytes_of_number(json.size(), 4) + json +
           bytes_of_number(slow_crc32(json), 4);
}

} // namespace springdrive::testing
