// Reads a record file, chunk by chunk, in constant memory.
//
//   RecordReader reader("grasp.rec");
//   reader.for_each([](const ServoSample &sample) { ... });
//   std::cout << reader.ending().text();
//
// Accepts any file. If its writer was killed or it is damaged, it is read up to the first invalid
// chunk; `ending` then reports what was not read, and why.
#pragma once

#include "engine/record/record_format.h"
#include "engine/servo/servo_sample.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::record {

/// What has been read so far, and, once `next` has returned false, how the file ended.
struct RecordEnding {
    std::uint64_t rows = 0;
    std::uint64_t notes = 0;
    std::uint64_t missing_ticks = 0;  ///< between the rows: lost samples
    std::uint64_t unusable_bytes = 0; ///< after the last valid chunk
    std::string why;                  ///< reason for unusable bytes; empty if there are none

    /// One line to display: "12000 rows" with what is missing.
    [[nodiscard]] std::string text() const;
};

class RecordReader {
public:
    /// @throw InputError naming the file, if it cannot be read, is not a record, or its header is
    ///        damaged.
    explicit RecordReader(const std::filesystem::path &path);

    [[nodiscard]] const RecordHeader &header() const { return header_; }
    [[nodiscard]] const std::filesystem::path &path() const { return path_; }

    /// Calls take(sample) for each row that is left and take_note(json) for each note, in their
    /// order. @throw InputError as `read_sample` does
    template <typename Take>
    void for_each(
        Take &&take,
        const std::function<void(std::string_view)> &take_note = [](std::string_view) {}) {
        while (next()) {
            if (is_note_) {
                take_note(note());
            }
            for (std::uint32_t row = 0; row < rows_; ++row) {
                take(read_sample(row));
            }
        }
    }

    /// Advances to the next chunk with rows or a note; false at the end.
    bool next();
    /// Returns to before the first chunk.
    void rewind();

    /// Number of rows in the chunk: 0 for a note.
    [[nodiscard]] std::uint32_t rows() const { return rows_; }
    /// A row of the chunk, `number` below rows(); header().row_bytes long; valid until `next`.
    [[nodiscard]] std::span<const std::byte> row(std::uint32_t number) const;
    [[nodiscard]] bool is_note() const { return is_note_; }
    /// The note's JSON text, unchecked.
    [[nodiscard]] std::string_view note() const;

    /// A row of the chunk, `number` below rows(), with columns identified by name.
    /// @throw InputError naming the file and the column that is missing or invalid.
    [[nodiscard]] servo::ServoSample read_sample(std::uint32_t number);

    [[nodiscard]] const RecordEnding &ending() const { return ending_; }

private:
    void read_header();
    void stop(const std::string &why);
    [[nodiscard]] bool read_exactly(std::span<std::byte> bytes);
    [[nodiscard]] std::string error(const ChunkHead &head, std::uint64_t left) const;
    [[nodiscard]] bool read_chunk(ChunkHead &head);
    void take_rows(std::uint32_t rows);

    std::filesystem::path path_;
    std::ifstream stream_;
    std::uint64_t file_bytes_ = 0;
    std::uint64_t first_chunk_at_ = 0;
    std::uint64_t position_ = 0; ///< after the last valid chunk
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
