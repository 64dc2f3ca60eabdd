// The layout of a record file (.rec): the full telemetry of a servo, one row per tick. This comment
// is all that is needed to read it with another program.
//
//   ┌───────────────┬──────────────────┬─────────────────┬───────────┬───────┬───────┬──
//   │ "SPRDREC1"    │ u32 length N     │ JSON, N bytes   │ u32 CRC   │ chunk │ chunk │ ...
//   │ 8 bytes       │                  │ UTF-8           │ of JSON   │       │       │
//   └───────────────┴──────────────────┴─────────────────┴───────────┴───────┴───────┴──
//
// All numbers are little-endian, without padding. CRC is the CRC-32 of zlib (Python: zlib.crc32).
// The last character of the magic is the version of this layout.
//
// A chunk is a head of 28 bytes and a payload:
//
//   offset  type    what
//        0  4 char  "CHNK"
//        4  u32     kind: 0 rows, 1 note; readers skip other kinds
//        8  u64     rows: tick of the first one; note: 0
//       16  u32     count of rows; note: 0
//       20  u32     bytes of payload that follow the head
//       24  u32     CRC of the 24 bytes before and the payload
//       28          payload
//
// The payload of rows is count × row_bytes: each row holds its columns in sequence. Their order,
// types (as NumPy codes) and offsets within a row are in the JSON header. The payload of a note is
// a JSON text: an event between two rows, such as a new scene, or a new servo rate: {"servo_hz":
// 2000.0, "from_tick": 1234}. A chunk has at most `chunk_rows` rows; a writer may end it early.
// Ticks increase from row to row; a gap means lost samples.
//
// A file whose writer was killed may end in the middle of a chunk: read up to the first chunk that
// is incomplete or whose CRC does not match. Ignore everything after it.
//
// The JSON header, an object:
//
//   format        "springdrive record 1"
//   software      version of the program that wrote it
//   started_utc   "2024-05-31T12:34:56Z"
//   servo_hz, period_s, delay_periods   the servo's rate [Hz], T [s], and d of the device, a real
//                 number; older files have an integer named delay_samples instead
//   row_bytes, chunk_rows               see above
//   columns       [{"name": "tick", "unit": "1", "type": "<u8", "offset": 0}, ...] in order; types
//                 "<u8" "<u4" "<u2" "<i4" "<f8" "|u1"; a name starts with a letter, then letters,
//                 digits and _; at most 63 of them
//   enums         {"map": ["inverse", "transpose"], ...}: names of a column's values
//   device        {"name", "file", "toml"}: toml is the file's complete text
//   tuning        all parameters at the start, named as in tuning files
//   scene         {"file", "sha256", "triangles"}: hash in lower-case hex
//   global_alpha_rad2_per_m2            α of alpha_mode "global"
//
// A number that is not finite is null in the header. In Python, all rows of a file at once:
//
//   head = json.loads(data[12:12+N])
//   dtype = np.dtype([(c["name"], c["type"]) for c in head["columns"]])
//   rows = np.concatenate([np.frombuffer(payload, dtype) for each chunk of kind 0])
#pragma once

#include "engine/control/tuning.h"
#include "engine/servo/servo_sample.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::record {

// Numbers are copied in their memory representation.
static_assert(std::endian::native == std::endian::little);

inline constexpr std::string_view kMagic = "SPRDREC1";
inline constexpr std::string_view kFormat = "springdrive record 1";

// A reader rejects larger sizes, so that no file makes it allocate excessive memory.
inline constexpr std::uint32_t kMaxHeaderBytes = 1U << 20U;
inline constexpr std::uint32_t kMaxPayloadBytes = 64U << 20U;

enum class ChunkKind : std::uint32_t { rows = 0, note = 1 };

/// As it is in a file.
struct ChunkHead {
    std::array<char, 4> magic{'C', 'H', 'N', 'K'};
    std::uint32_t kind = 0;
    std::uint64_t first_tick = 0;
    std::uint32_t rows = 0;
    std::uint32_t payload_bytes = 0;
    std::uint32_t crc = 0;
};
inline constexpr std::size_t kChunkHeadBytes = 28;
static_assert(offsetof(ChunkHead, first_tick) == 8 &&
              offsetof(ChunkHead, crc) == kChunkHeadBytes - sizeof(ChunkHead::crc));

/// zlib's CRC-32 of `bytes`, continuing from the CRC `before` of the preceding bytes.
[[nodiscard]] std::uint32_t crc32_of(std::span<const std::byte> bytes, std::uint32_t before = 0);

template <typename Number> [[nodiscard]] Number load(const std::byte *from) {
    Number number{};
    std::memcpy(&number, from, sizeof number);
    return number;
}

template <typename Number> void store(std::byte *to, Number number) {
    std::memcpy(to, &number, sizeof number);
}

/// Fills in the head, including the CRC, of a chunk whose payload is already in place.
void seal_chunk(std::span<std::byte> head_and_payload, ChunkKind kind, std::uint64_t first_tick,
                std::uint32_t rows);

// The header of a record file.

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

// Converts a ServoSample to the bytes of a row, and back.

/// The columns of this version's ServoSample.
[[nodiscard]] std::vector<RecordColumn> sample_columns();

/// Names of the values of its enum columns.
[[nodiscard]] std::map<std::string, std::vector<std::string>> sample_enum_names();

/// @param row  of the length given by `sample_columns`. Does not allocate.
void encode(const servo::ServoSample &sample, std::byte *row);

/// Reads rows of a file whose columns may be in another order, with additional ones in between.
class RowDecoder {
public:
    /// @throw InputError naming the first column that is of another type, or missing though records
    ///        have always had it.
    explicit RowDecoder(const RecordHeader &header);

    /// @param row  of header.row_bytes
    /// @throw InputError for an enum value that this version does not know.
    [[nodiscard]] servo::ServoSample decode(std::span<const std::byte> row) const;

private:
    std::vector<std::uint32_t> offset_; ///< of each column, in the order of `for_each_column`
};

} // namespace springdrive::record
