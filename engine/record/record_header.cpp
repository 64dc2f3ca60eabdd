#include "engine/record/record_header.h"

#include "base/input_error.h"
#include "device/core/calibration.h"
#include "engine/record/record_format.h"
#include "engine/record/row_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>

namespace springdrive::record {

namespace {

constexpr double kChunk_s = 0.02;

struct TypeCode {
    ColumnType type;
    std::uint32_t bytes;
    std::string_view code;
};

/// Indexed by ColumnType.
constexpr std::array<TypeCode, 6> kTypeCodes{{{ColumnType::u8, 1, "|u1"},
                                              {ColumnType::u16, 2, "<u2"},
                                              {ColumnType::u32, 4, "<u4"},
                                              {ColumnType::u64, 8, "<u8"},
                                              {ColumnType::i32, 4, "<i4"},
                                              {ColumnType::f64, 8, "<f8"}}};

} // namespace

std::uint32_t bytes_of(ColumnType type) { return kTypeCodes[static_cast<std::size_t>(type)].bytes; }

std::string_view code_of(ColumnType type) {
    return kTypeCodes[static_cast<std::size_t>(type)].code;
}

std::optional<ColumnType> column_type_with_code(std::string_view code) {
    const auto *const found = std::find_if(kTypeCodes.begin(), kTypeCodes.end(),
                                           [&](const TypeCode &t) { return t.code == code; });
    return found == kTypeCodes.end() ? std::nullopt : std::optional(found->type);
}

const RecordColumn *RecordHeader::column(std::string_view name) const {
    const auto found = std::find_if(columns.begin(), columns.end(),
                                    [name](const RecordColumn &c) { return c.name == name; });
    return found == columns.end() ? nullptr : &*found;
}

RecordHeader record_header(double servo_hz) {
    if (!std::isfinite(servo_hz) || servo_hz <= 0.0 || servo_hz > 1e6) {
        throw InputError("a servo rate of " + std::to_string(servo_hz) +
                         " Hz cannot be recorded; give one above 0, up to 1000000");
    }
    RecordHeader header;
    header.servo_hz = servo_hz;
    header.period_s = 1.0 / servo_hz;
    header.started_utc = device::text_of_utc(std::time(nullptr));
    header.columns = sample_columns();
    header.enum_names = sample_enum_names();
    header.row_bytes = header.columns.back().offset + bytes_of(header.columns.back().type);
    const std::uint32_t max_rows = kMaxPayloadBytes / header.row_bytes;
    header.chunk_rows = static_cast<std::uint32_t>(
        std::clamp(std::round(kChunk_s * servo_hz), 1.0, static_cast<double>(max_rows)));
    return header;
}

} // namespace springdrive::record
