// The layout of a record file (.rec): the full telemetry of a servo, one row a tick. Whoever wants
// to read it with another program needs no more than this comment.
//
//   ┌───────────────┬──────────────────┬─────────────────┬───────────┬───────┬───────┬──
//   │ "SPRDREC1"    │ u32 length N     │ JSON, N bytes   │ u32 CRC   │ chunk │ chunk │ ...
//   │ 8 bytes       │                  │ UTF-8           │ of JSON   │       │       │
//   └───────────────┴──────────────────┴─────────────────┴───────────┴───────┴───────┴──
//
// All numbers are little endian, nothing is padded. CRC is the CRC-32 of zlib (Python: zlib.crc32).
// The last letter of the magic is the version of this layout.
//
// A chunk is a head of 28 bytes and its payload:
//
//   offset  type    what
//        0  4 char  "CHNK"
//        4  u32     kind: 0 rows, 1 note; skip what you do not know
//        8  u64     rows: tick of the first one; note: 0
//       16  u32     count of rows; note: 0
//       20  u32     bytes of payload that follow the head
//       24  u32     CRC of the 24 bytes before and the payload
//       28          payload
//
// The payload of rows is count × row_bytes: each row holds its columns one after the other. Their
// order, types and offsets within a row stand in the JSON header, types in numpy's codes. The
// payload of a note is a JSON text: something that happened between two rows, such as another
// scene, or another servo rate: {"servo_hz": 2000.0, "from_tick": 1234}. A chunk has at most
// `chunk_rows` rows; a writer may end one early. Ticks grow from row to row; where they skip,
// samples were lost.
//
// A file whose writer was killed ends in the midst of a chunk or before one: read up to the first
// chunk that is incomplete or whose CRC does not fit. Nothing after that is of use.
//
// The JSON header, an object:
//
//   format        "springdrive record 1"
//   software      version of the program that wrote it
//   started_utc   "2024-05-31T12:34:56Z"
//   servo_hz, period_s, delay_periods   the servo's rate [Hz], T [s], and d of the device, a real
//                 number; it was whole and called delay_samples before, and files may still say so
//   row_bytes, chunk_rows               see above
//   columns       [{"name": "tick", "unit": "1", "type": "<u8", "offset": 0}, ...] in order; types
//                 "<u8" "<u4" "<u2" "<i4" "<f8" "|u1"; a name starts with a letter, then letters,
//                 digits and _; at most 63 of them
//   enums         {"map": ["inverse", "transpose"], ...}: what the numbers of a column stand for
//   device        {"name", "file", "toml"}: the last is the file's whole text
//   tuning        all parameters at the start, by their names as in tuning files
//   scene         {"file", "sha256", "triangles"}: hash in lower-case hex
//   global_alpha_rad2_per_m2            what alpha_mode "global" takes
//
// A number that is not finite is null there. In Python, all rows of a file at once:
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

// Numbers are copied as they lie in memory.
static_assert(std::endian::native == std::endian::little);

inline constexpr std::string_view kMagic = "SPRDREC1";
inline constexpr std::string_view kFormat = "springdrive record 1";
inline constexpr std::string_view kChunkMagic = "CHNK";
inline constexpr std::size_t kChunkHeadBytes = 28;

// A reader refuses more, so that no file makes it ask for much memory.
inline constexpr std::uint32_t kMostHeaderBytes = 1U << 20U;
inline constexpr std::uint32_t kMostPayloadBytes = 64U << 20U;

enum class ChunkKind : std::uint32_t { rows = 0, note = 1 };

struct ChunkHead {
    std::uint32_t kind = 0;
    std::uint64_t first_tick = 0;
    std::uint32_t rows = 0;
    std::uint32_t payload_bytes = 0;
    std::uint32_t crc = 0;
};

/// zlib's CRC-32, of `bytes` after what `before` is the CRC of.
[[nodiscard]] std::uint32_t crc32_of(std::span<const std::byte> bytes, std::uint32_t before = 0);

template <typename Number> [[nodiscard]] Number load(const std::byte *from) {
    Number number{};
    std::memcpy(&number, from, sizeof number);
    return number;
}

template <typename Number> void store(std::byte *to, Number number) {
    std::memcpy(to, &number, sizeof number);
}

/// Fills in the head of a chunk whose payload already stands behind it, with its CRC.
void seal_chunk(std::span<std::byte> head_and_payload, ChunkKind kind, std::uint64_t first_tick,
                std::uint32_t rows);

/// False where the magic is not there.
[[nodiscard]] bool parse_chunk_head(std::span<const std::byte, kChunkHeadBytes> bytes,
                                    ChunkHead &head);

} // namespace springdrive::record
