#include "engine/record/row_codec.h"

#include "base/input_error.h"
#include "engine/control/tuning.h"
#include "engine/record/record_format.h"
#include "engine/record/telemetry_columns.h"

#include <limits>
#include <type_traits>

namespace springdrive::record {

namespace {

template <typename Scalar> constexpr ColumnType type_of() {
    if constexpr (std::is_same_v<Scalar, bool> || std::is_enum_v<Scalar>) {
        static_assert(sizeof(Scalar) == 1);
        return ColumnType::u8;
    } else if constexpr (std::is_same_v<Scalar, std::uint16_t>) {
        return ColumnType::u16;
    } else if constexpr (std::is_same_v<Scalar, std::uint32_t>) {
        return ColumnType::u32;
    } else if constexpr (std::is_same_v<Scalar, std::uint64_t>) {
        return ColumnType::u64;
    } else if constexpr (std::is_same_v<Scalar, std::int32_t>) {
        return ColumnType::i32;
    } else {
        static_assert(std::is_same_v<Scalar, double>, "a record has no such type");
        return ColumnType::f64;
    }
}

/// Names of an enum's values, in order, for each enum in a sample.
template <typename Enum> std::vector<std::string> names_of() {
    if constexpr (std::is_same_v<Enum, device::DeviceHealth>) {
        return {"ok", "lost"};
    } else if constexpr (std::is_same_v<Enum, device::Arrival>) {
        return {"fresh", "late", "repeated", "corrupt", "absent"};
    } else if constexpr (std::is_same_v<Enum, device::CommandMode>) {
        return {"brake", "drive", "open"};
    } else if constexpr (std::is_same_v<Enum, control::MotionMap>) {
        return {control::kMotionMapNames.begin(), control::kMotionMapNames.end()};
    } else if constexpr (std::is_same_v<Enum, control::AlphaMode>) {
        return {control::kAlphaModeNames.begin(), control::kAlphaModeNames.end()};
    } else if constexpr (std::is_same_v<Enum, servo::SafetyState>) {
        return {"waiting", "starting", "running", "tripped", "releasing"};
    } else if constexpr (std::is_same_v<Enum, servo::ForceLimit>) {
        return {servo::kForceLimitNames.begin(), servo::kForceLimitNames.end()};
    } else {
        static_assert(std::is_same_v<Enum, servo::TripCause>, "name the values of this enum here");
        return {servo::kTripCauseNames.begin(), servo::kTripCauseNames.end()};
    }
}

constexpr std::uint32_t kMissing = std::numeric_limits<std::uint32_t>::max();

/// Older records lack these columns; their samples have the defaults.
bool is_recent(std::string_view column) { return column == "held_stop"; }

template <typename Enum> bool is_known(std::uint8_t number) {
    static const std::size_t known = names_of<Enum>().size();
    return number < known;
}

template <typename Scalar>
void load_into(Scalar &value, const std::byte *from, std::string_view name) {
    if constexpr (std::is_same_v<Scalar, bool>) {
        value = load<std::uint8_t>(from) != 0;
    } else if constexpr (std::is_enum_v<Scalar>) {
        const auto number = load<std::uint8_t>(from);
        if (!is_known<Scalar>(number)) {
            throw InputError("column " + std::string(name) + " holds " + std::to_string(number) +
                             ", which this version does not know; use the one that recorded it");
        }
        value = static_cast<Scalar>(number);
    } else {
        value = load<Scalar>(from);
    }
}

} // namespace

std::vector<RecordColumn> sample_columns() {
    std::vector<RecordColumn> columns;
    std::uint32_t offset = 0;
    const servo::ServoSample sample;
    for_each_column(sample, [&](std::string_view name, std::string_view unit, const auto &value) {
        const ColumnType type = type_of<std::remove_cvref_t<decltype(value)>>();
        columns.push_back({std::string(name), std::string(unit), type, offset});
        offset += bytes_of(type);
    });
    return columns;
}

std::map<std::string, std::vector<std::string>> sample_enum_names() {
    std::map<std::string, std::vector<std::string>> names;
    const servo::ServoSample sample;
    for_each_column(sample, [&](std::string_view name, std::string_view, const auto &value) {
        using Scalar = std::remove_cvref_t<decltype(value)>;
        if constexpr (std::is_enum_v<Scalar>) {
            names[std::string(name)] = names_of<Scalar>();
        }
    });
    return names;
}

void encode(const servo::ServoSample &sample, std::byte *row) {
    for_each_column(sample, [&](std::string_view, std::string_view, const auto &value) {
        store(row, value);
        row += sizeof value;
    });
}

RowDecoder::RowDecoder(const RecordHeader &header) {
    for (const RecordColumn &wanted : sample_columns()) {
        const RecordColumn *const found = header.column(wanted.name);
        if (found == nullptr && is_recent(wanted.name)) {
            offset_.push_back(kMissing);
            continue;
        }
        if (found == nullptr) {
            throw InputError("the record has no column " + wanted.name +
                             ", so it is of another version; only exports can read it");
        }
        if (found->type != wanted.type) {
            throw InputError("the record's column " + wanted.name + " is of type " +
                             std::string(code_of(found->type)) + ", not " +
                             std::string(code_of(wanted.type)) + "; only exports can read it");
        }
        offset_.push_back(found->offset);
    }
}

servo::ServoSample RowDecoder::decode(std::span<const std::byte> row) const {
    servo::ServoSample sample;
    const std::uint32_t *offset = offset_.data();
    for_each_column(sample, [&](std::string_view name, std::string_view, auto &value) {
        if (const std::uint32_t at = *offset++; at != kMissing) {
            load_into(value, row.data() + at, name);
        }
    });
    return sample;
}

} // namespace springdrive::record
