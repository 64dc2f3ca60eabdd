// The header of a record file; see record_format.h for its layout.
#pragma once

#include "engine/control/tuning.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::record {

enum class ColumnType : std::uint8_t { u8, u16, u32, u64, i32, f64 };

[[nodiscard]] std::uint32_t bytes_of(ColumnType type);

/// NumPy's code: "<u8" for u64, "|u1" for u8.
[[nodiscard]] std::string_view code_of(ColumnType type);
[[nodiscard]] std::optional<ColumnType> column_type_with_code(std::string_view code);

struct RecordColumn {
    std::string name;
    std::string unit;
    ColumnType type = ColumnType::f64;
    std::uint32_t offset = 0; ///< within a row

    bool operator==(const RecordColumn &) const = default;
};

/// `record_header` sets the first half, the recording code the second.
struct RecordHeader {
    double servo_hz = 0.0;
    double period_s = 0.0;
    std::string started_utc;
    std::uint32_t row_bytes = 0;
    std::uint32_t chunk_rows = 0;
    std::vector<RecordColumn> columns;
    /// Names of a column's values, by column.
    std::map<std::string, std::vector<std::string>> enum_names;

    std::string software;       ///< version of the program
    double delay_periods = 0.0; ///< d of the device
    std::string device_name;
    std::string device_file;
    std::string device_toml; ///< the file's complete text
    control::Tuning tuning;  ///< at the start; NaN for values missing in a file of another version
    std::string scene_file;  ///< empty: none
    std::string scene_sha256;
    std::uint64_t scene_triangles = 0;
    double global_alpha_rad2_per_m2 = 0.0;

    [[nodiscard]] const RecordColumn *column(std::string_view name) const;
};

/// A header with the present time, the columns of this version's ServoSample and chunks of 20 ms.
/// @throw InputError for a rate that is not a positive number.
[[nodiscard]] RecordHeader record_header(double servo_hz);

[[nodiscard]] std::string to_json(const RecordHeader &header);

/// Accepts records of other versions: only what is needed to read the rows is required.
/// @throw InputError, without the file's name, for a text that is not JSON or describes an invalid
///        row layout.
[[nodiscard]] RecordHeader from_json(std::string_view text);

} // namespace springdrive::record
