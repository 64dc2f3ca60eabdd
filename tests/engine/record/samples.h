// Samples and small records for the tests of records.
#pragma once

#include "base/input_error.h"
#include "engine/record/record_writer.h"
#include "engine/record/row_codec.h"
#include "engine/record/telemetry_columns.h"
#include "tests/support/error_text.h"
#include "tests/support/files.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <string>
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

} // namespace springdrive::testing
