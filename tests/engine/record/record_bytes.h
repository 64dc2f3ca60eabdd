// Parses a record file from its documentation alone, without the code under test.
#pragma once

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::testing {

/// Bit by bit, from the polynomial.
inline std::uint32_t slow_crc32(std::string_view bytes) {
    std::uint32_t crc = 0xFFFFFFFFU;
    for (const char byte : bytes) {
        crc ^= static_cast<std::uint8_t>(byte);
        for (int bit = 0; bit < 8; ++bit) {
            crc = (crc >> 1U) ^ (crc % 2 == 1 ? 0xEDB88320U : 0U);
        }
    }
    return ~crc;
}

/// Little endian.
inline std::uint64_t number_at(std::string_view bytes, std::size_t at, std::size_t length) {
    std::uint64_t number = 0;
    for (std::size_t i = length; i-- > 0;) {
        number = number << 8U | static_cast<std::uint8_t>(bytes.at(at + i));
    }
    return number;
}

inline std::string bytes_of_number(std::uint64_t number, std::size_t length) {
    std::string bytes;
    for (std::size_t i = 0; i < length; ++i) {
        bytes += static_cast<char>(number >> (8 * i) & 0xFFU);
    }
    return bytes;
}

struct ChunkBytes {
    std::size_t at = 0; ///< in the file
    std::uint64_t kind = 0;
    std::uint64_t first_tick = 0;
    std::uint64_t rows = 0;
    std::string payload;
};

struct RecordBytes {
    std::string json;
    std::vector<ChunkBytes> chunks;
};

/// @throw std::exception for any byte that is not as documented.
inline RecordBytes take_apart(const std::string &file) {
    const auto insist = [](bool is_so, const char *what) {
        if (!is_so) {
            throw std::runtime_error(what);
        }
    };
    insist(file.substr(0, 8) == "SPRDREC1", "magic");
    RecordBytes record;
    const std::uint64_t length = number_at(file, 8, 4);
    record.json = file.substr(12, length);
    insist(number_at(file, 12 + length, 4) == slow_crc32(record.json), "CRC of the header");
    std::size_t at = 16 + length;
    while (at != file.size()) {
        insist(file.substr(at, 4) == "CHNK", "magic of a chunk");
        const std::uint64_t bytes = number_at(file, at + 20, 4);
        record.chunks.push_back({at, number_at(file, at + 4, 4), number_at(file, at + 8, 8),
                                 number_at(file, at + 16, 4), file.substr(at + 28, bytes)});
        const std::string &payload = record.chunks.back().payload;
        insist(payload.size() == bytes, "length of a chunk");
        insist(number_at(file, at + 24, 4) == slow_crc32(file.substr(at, 24) + payload),
               "CRC of a chunk");
        at += 28 + bytes;
    }
    return record;
}

inline std::string chunk_bytes(std::uint64_t kind, std::uint64_t first_tick, std::uint64_t rows,
                               const std::string &payload) {
    const std::string head = "CHNK" + bytes_of_number(kind, 4) + bytes_of_number(first_tick, 8) +
                             bytes_of_number(rows, 4) + bytes_of_number(payload.size(), 4);
    return head + bytes_of_number(slow_crc32(head + payload), 4) + payload;
}

inline std::string header_bytes(const std::string &json) {
    return "SPRDREC1" + bytes_of_number(json.size(), 4) + json +
           bytes_of_number(slow_crc32(json), 4);
}

} // namespace springdrive::testing
