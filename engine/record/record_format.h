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

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

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

} // namespace springdrive::record
