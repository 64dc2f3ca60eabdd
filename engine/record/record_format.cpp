#include "engine/record/record_format.h"

#include <zlib.h>

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

} // namespace springdrive::record
