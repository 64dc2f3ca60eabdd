// Covers engine/record/record_format.cpp.
#include "engine/record/record_format.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <string_view>

namespace springdrive::record {
namespace {

std::span<const std::byte> bytes_of(std::string_view text) {
    return {reinterpret_cast<const std::byte *>(text.data()), text.size()};
}

// The published check value of CRC-32.
TEST(RecordFormat, UsesTheCommonCrc32) {
    EXPECT_EQ(crc32_of(bytes_of("123456789")), 0xCBF43926U);
    EXPECT_EQ(crc32_of({}), 0U);
}

TEST(RecordFormat, ComputesACrcInPieces) {
    const std::uint32_t first = crc32_of(bytes_of("1234"));
    EXPECT_EQ(crc32_of(bytes_of("56789"), first), 0xCBF43926U);
    EXPECT_EQ(crc32_of({}, first), first);
}

TEST(RecordFormat, WritesAChunksHeadAsDocumented) {
    std::array<std::byte, kChunkHeadBytes + 9> chunk{};
    std::memcpy(chunk.data() + kChunkHeadBytes, "123456789", 9);
    seal_chunk(chunk, ChunkKind::note, 0x0102030405060708U, 0x0A0B0C0DU);
    const std::string_view head(reinterpret_cast<const char *>(chunk.data()), 24);
    using namespace std::string_view_literals;
    EXPECT_EQ(head, "CHNK\x01\0\0\0\x08\x07\x06\x05\x04\x03\x02\x01\x0D\x0C\x0B\x0A\x09\0\0\0"sv);
    std::string sealed(head);
    sealed += "123456789";
    EXPECT_EQ(load<std::uint32_t>(chunk.data() + 24), crc32_of(bytes_of(sealed)));
}

TEST(RecordFormat, ReadsBackWhatItSealed) {
    std::array<std::byte, kChunkHeadBytes + 3> chunk{};
    seal_chunk(chunk, ChunkKind::rows, 77, 5);
    ChunkHead head;
    const auto bytes = std::span<const std::byte, kChunkHeadBytes>(chunk.data(), kChunkHeadBytes);
    ASSERT_TRUE(parse_chunk_head(bytes, head));
    EXPECT_EQ(head.kind, 0U);
    EXPECT_EQ(head.first_tick, 77U);
    EXPECT_EQ(head.rows, 5U);
    EXPECT_EQ(head.payload_bytes, 3U);
    chunk[3] = std::byte{'X'};
    EXPECT_FALSE(parse_chunk_head(bytes, head));
}

} // namespace
} // namespace springdrive::record
