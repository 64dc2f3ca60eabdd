#include "engine/record/record_format.h"

#include <zlib.h>

#include <algorithm>

namespace springdrive::record {

namespace {

constexpr std::size_t kKindAt = 4;
constexpr std::size_t kFirstTickAt = 8;
constexpr std::size_t kRowsAt = 16;
constexpr std::size_t kPayloadBytesAt = 20;
constexpr std::size_t kCrcAt = 24;

} // namespace

std::uint32_t crc32_of(std::span<const std::byte> bytes, std::uint32_t before) {
    if (bytes.empty()) {
        return before; // zlib would interpret a null pointer as a reset
    }
    return static_cast<std::uint32_t>(
        crc32_z(before, reinterpret_cast<const Bytef *>(bytes.data()), bytes.size()));
}

void seal_chunk(std::span<std::byte> head_and_payload, ChunkKind kind, std::uint64_t first_tick,
                std::uint32_t rows) {
    std::byte *head = head_and_payload.data();
    const auto payload = head_and_payload.subspan(kChunkHeadBytes);
    std::memcpy(head, kChunkMagic.data(), kChunkMagic.size());
    store(head + kKindAt, static_cast<std::uint32_t>(kind));
    store(head + kFirstTickAt, first_tick);
    store(head + kRowsAt, rows);
    store(head + kPayloadBytesAt, static_cast<std::uint32_t>(payload.size()));
    store(head + kCrcAt, crc32_of(payload, crc32_of(head_and_payload.first(kCrcAt))));
}

bool parse_chunk_head(std::span<const std::byte, kChunkHeadBytes> bytes, ChunkHead &head) {
    if (std::memcmp(bytes.data(), kChunkMagic.data(), kChunkMagic.size()) != 0) {
        return false;
    }
    head.kind = load<std::uint32_t>(bytes.data() + kKindAt);
    head.first_tick = load<std::uint64_t>(bytes.data() + kFirstTickAt);
    head.rows = load<std::uint32_t>(bytes.data() + kRowsAt);
    head.payload_bytes = load<std::uint32_t>(bytes.data() + kPayloadBytesAt);
    head.crc = load<std::uint32_t>(bytes.data() + kCrcAt);
    return true;
}

} // namespace springdrive::record
