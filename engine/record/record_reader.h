// Reads a record file, chunk by chunk: memory stays flat, however large the file is.
//
//   RecordReader reader("grasp.rec");
//   while (reader.next()) {
//       for (std::uint32_t row = 0; row < reader.rows(); ++row) {
//           const ServoSample sample = reader.read_sample(row);
//       }
//   }
//   std::cout << reader.ending().text();
//
// Any file can be given to it. One whose writer was killed, or that is damaged, is read up to its
// first chunk that is not whole; `ending` then says what was left unread, and why.
#pragma once

#include "engine/record/record_format.h"
#include "engine/record/record_header.h"
#include "engine/record/row_codec.h"
#include "engine/servo/servo_sample.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::record {

/// What was read so far, and how the file ended once `next` has returned false.
struct RecordEnding {
    std::uint64_t rows = 0;
    std::uint64_t notes = 0;
    std::uint64_t missing_ticks = 0;  ///< between the rows: samples that were lost
    std::uint64_t unusable_bytes = 0; ///< after the last whole chunk
    std::string why;                  ///< they are unusable; empty when there are none

    /// One line for people: "12000 rows" with what is missing.
    [[nodiscard]] std::string text() const;
};

class RecordReader {
public:
    /// @throw InputError naming the file, where it cannot be read, is no record, or its header is
    ///        damaged.
    explicit RecordReader(const std::filesystem::path &path);

    [[nodiscard]] const RecordHeader &header() const { return header_; }
    [[nodiscard]] const std::filesystem::path &path() const { return path_; }

    /// Goes on to the next chunk that holds rows or a note; false at the end.
    bool next();
    /// Goes back before the first chunk.
    void rewind();

    /// Of the chunk: 0 in a note.
    [[nodiscard]] std::uint32_t rows() const { return rows_; }
    /// Of the chunk, below rows(); header().row_bytes long; good until `next`.
    [[nodiscard]] std::span<const std::byte> row(std::uint32_t number) const;
    [[nodiscard]] bool is_note() const { return is_note_; }
    /// Its JSON text; not checked, as anybody may have written it.
    [[nodiscard]] std::string_view note() const;

    /// A row of the chunk, below rows(), with its columns found by their names.
    /// @throw InputError naming the file and the column that is missing or not understood.
    [[nodiscard]] servo::ServoSample read_sample(std::uint32_t number);

    [[nodiscard]] const RecordEnding &ending() const { return ending_; }

private:
    void read_header();
    void stop(const std::string &why);
    [[nodiscard]] bool read_exactly(std::span<std::byte> bytes);
    [[nodiscard]] std::string complaint(const ChunkHead &head, std::uint64_t left) const;
    [[nodiscard]] bool read_chunk(ChunkHead &head);
    void take_rows(std::uint32_t rows);

    std::filesystem::path path_;
    std::ifstream stream_;
    std::uint64_t file_bytes_ = 0;
    std::uint64_t first_chunk_at_ = 0;
    std::uint64_t position_ = 0; ///< after the last whole chunk
    RecordHeader header_;
    std::optional<std::uint32_t> tick_offset_; ///< within a row
    std::optional<RowDecoder> decoder_;
    std::vector<std::byte> payload_;
    std::uint32_t rows_ = 0;
    bool is_note_ = false;
    bool at_end_ = false;
    std::optional<std::uint64_t> last_tick_;
    RecordEnding ending_;
};

} // namespace springdrive::record
