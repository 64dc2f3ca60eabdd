#include "engine/record/record_format.h"

#include "base/input_error.h"
#include "base/text.h"
#include "device/core/device_description.h"
#include "engine/control/tuning.h"
#include "engine/record/telemetry_columns.h"

#include <nlohmann/json.hpp>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <limits>
#include <set>
#include <type_traits>

namespace springdrive::record {

std::uint32_t crc32_of(std::span<const std::byte> bytes, std::uint32_t before) {
    if (bytes.empty()) {
        return before; // zlib would interpret a null pointer as a reset
    }
    return static_cast<std::uint32_t>(
        crc32_z(before, reinterpret_cast<const Bytef *>(bytes.data()), bytes.size()));
}

void seal_chunk(std::span<std::byte> head_and_payload, ChunkKind kind, std::uint64_t first_tick,
                std::uint32_t rows) {
    const auto payload = head_and_payload.subspan(kChunkHeadBytes);
    ChunkHead head;
    head.kind = static_cast<std::uint32_t>(kind);
    head.first_tick = first_tick;
    head.rows = rows;
    head.payload_bytes = static_cast<std::uint32_t>(payload.size());
    std::memcpy(head_and_payload.data(), &head, kChunkHeadBytes);
    const auto before_crc = head_and_payload.first(offsetof(ChunkHead, crc));
    store(head_and_payload.data() + before_crc.size(), crc32_of(payload, crc32_of(before_crc)));
}

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

using nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

constexpr std::size_t kMaxName = 63; // MATLAB's limit
constexpr std::size_t kMaxColumns = 10'000;

OrderedJson tuning_to_json(const control::Tuning &tuning) {
    OrderedJson object;
    for (const control::Parameter &parameter : control::kParameters) {
        object[std::string(parameter.name)] = tuning.*parameter.value;
    }
    object["map"] = control::name_of(tuning.map);
    object["alpha_mode"] = control::name_of(tuning.alpha_mode);
    return object;
}

/// The member of an object, or null.
const json &member(const json &object, std::string_view key) {
    static const json nothing;
    const auto found = object.find(key);
    return found == object.end() ? nothing : *found;
}

std::string text_or_nothing(const json &object, std::string_view key) {
    const json &value = member(object, key);
    return value.is_string() ? value.get<std::string>() : std::string();
}

double number_or_nan(const json &object, std::string_view key) {
    const json &value = member(object, key);
    return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::uint64_t count_or(const json &object, std::string_view key, std::uint64_t otherwise) {
    const json &value = member(object, key);
    return value.is_number_unsigned() ? value.get<std::uint64_t>() : otherwise;
}

[[noreturn]] void refuse(const std::string &what) {
    throw InputError("its header " + what + "; it is damaged or not a springdrive record");
}

/// d; older files have an integer named delay_samples instead; 0 if neither is present.
double delay_periods(const json &object) {
    const bool has_old_name = object.contains("delay_samples");
    if (has_old_name && object.contains("delay_periods")) {
        refuse("has both delay_periods and delay_samples");
    }
    const double d = number_or_nan(object, has_old_name ? "delay_samples" : "delay_periods");
    return d >= 0.0 && std::isfinite(d) ? d : 0.0;
}

control::Tuning tuning_from_json(const json &object) {
    control::Tuning tuning;
    for (const control::Parameter &parameter : control::kParameters) {
        tuning.*parameter.value = number_or_nan(object, parameter.name);
    }
    tuning.map = control::motion_map_named(text_or_nothing(object, "map")).value_or(tuning.map);
    tuning.alpha_mode = control::alpha_mode_named(text_or_nothing(object, "alpha_mode"))
                            .value_or(tuning.alpha_mode);
    return tuning;
}

bool is_legal_name(const std::string &name) {
    const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    return !name.empty() && name.size() <= kMaxName && is_letter(name[0]) &&
           std::all_of(name.begin(), name.end(),
                       [&](char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '_'; });
}

RecordColumn column_from_json(const json &object, std::uint32_t offset, std::size_t number) {
    const std::string which = "column " + std::to_string(number);
    const auto type = column_type_with_code(text_or_nothing(object, "type"));
    if (!type) {
        refuse("gives " + which + " an unknown type");
    }
    RecordColumn column{text_or_nothing(object, "name"), text_or_nothing(object, "unit"), *type,
                        offset};
    if (!is_legal_name(column.name)) {
        refuse("gives " + which + " an invalid name");
    }
    if (count_or(object, "offset", offset) != offset) {
        refuse("gives " + which + " an invalid offset");
    }
    return column;
}

void read_columns(const json &list, RecordHeader &header) {
    if (!list.is_array() || list.empty() || list.size() > kMaxColumns) {
        refuse("has no usable list of columns");
    }
    std::uint32_t offset = 0;
    std::set<std::string> names;
    for (const json &object : list) {
        header.columns.push_back(column_from_json(object, offset, header.columns.size() + 1));
        const RecordColumn &column = header.columns.back();
        if (!names.insert(column.name).second) {
            refuse("has more than one column " + column.name);
        }
        offset += bytes_of(column.type);
    }
    header.row_bytes = offset;
}

void read_enum_names(const json &enums, RecordHeader &header) {
    if (!enums.is_object()) {
        return;
    }
    for (const auto &[column, names] : enums.items()) {
        for (const json &name : names) {
            header.enum_names[column].push_back(name.is_string() ? name.get<std::string>() : "");
        }
    }
}

void read_rows_layout(const json &document, RecordHeader &header) {
    header.servo_hz = number_or_nan(document, "servo_hz");
    header.period_s = number_or_nan(document, "period_s");
    if (!(header.period_s > 0.0)) {
        refuse("has no period_s above 0");
    }
    read_columns(member(document, "columns"), header);
    if (count_or(document, "row_bytes", 0) != header.row_bytes) {
        refuse("has columns that do not add up to its row_bytes");
    }
    const std::uint64_t chunk_rows = count_or(document, "chunk_rows", 0);
    if (chunk_rows == 0 || chunk_rows > kMaxPayloadBytes / header.row_bytes) {
        refuse("has an invalid chunk_rows");
    }
    header.chunk_rows = static_cast<std::uint32_t>(chunk_rows);
}

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

std::string to_json(const RecordHeader &header) {
    OrderedJson document;
    document["format"] = kFormat;
    document["software"] = header.software;
    document["started_utc"] = header.started_utc;
    document["servo_hz"] = header.servo_hz;
    document["period_s"] = header.period_s;
    document["delay_periods"] = header.delay_periods;
    document["row_bytes"] = header.row_bytes;
    document["chunk_rows"] = header.chunk_rows;
    document["columns"] = OrderedJson::array();
    for (const RecordColumn &column : header.columns) {
        document["columns"].push_back({{"name", column.name},
                                       {"unit", column.unit},
                                       {"type", code_of(column.type)},
                                       {"offset", column.offset}});
    }
    document["enums"] = header.enum_names;
    document["device"] = {
        {"name", header.device_name}, {"file", header.device_file}, {"toml", header.device_toml}};
    document["tuning"] = tuning_to_json(header.tuning);
    document["scene"] = {{"file", header.scene_file},
                         {"sha256", header.scene_sha256},
                         {"triangles", header.scene_triangles}};
    document["global_alpha_rad2_per_m2"] = header.global_alpha_rad2_per_m2;
    // File names may contain invalid UTF-8.
    return json_text(document, -1);
}

RecordHeader from_json(std::string_view text) {
    const json document = json::parse(text.begin(), text.end(), nullptr, false);
    if (!document.is_object()) {
        refuse("is not a JSON object");
    }
    if (text_or_nothing(document, "format") != kFormat) {
        refuse("does not say \"" + std::string(kFormat) + "\"");
    }
    RecordHeader header;
    read_rows_layout(document, header);
    read_enum_names(member(document, "enums"), header);
    header.software = text_or_nothing(document, "software");
    header.started_utc = text_or_nothing(document, "started_utc");
    header.delay_periods = delay_periods(document);
    const json &device = member(document, "device");
    header.device_name = text_or_nothing(device, "name");
    header.device_file = text_or_nothing(device, "file");
    header.device_toml = text_or_nothing(device, "toml");
    header.tuning = tuning_from_json(member(document, "tuning"));
    const json &scene = member(document, "scene");
    header.scene_file = text_or_nothing(scene, "file");
    header.scene_sha256 = text_or_nothing(scene, "sha256");
    header.scene_triangles = count_or(scene, "triangles", 0);
    header.global_alpha_rad2_per_m2 = number_or_nan(document, "global_alpha_rad2_per_m2");
    return header;
}

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
    for (const RecordColumn &requested : sample_columns()) {
        const RecordColumn *const found = header.column(requested.name);
        if (found == nullptr && is_recent(requested.name)) {
            offset_.push_back(kMissing);
            continue;
        }
        if (found == nullptr) {
            throw InputError("the record has no column " + requested.name +
                             ", so it is of another version; only exports can read it");
        }
        if (found->type != requested.type) {
            throw InputError("the record's column " + requested.name + " is of type " +
                             std::string(code_of(found->type)) + ", not " +
                             std::string(code_of(requested.type)) + "; only exports can read it");
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
