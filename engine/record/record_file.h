// A record's file, written and read chunk by chunk.
#pragma once

#include "base/new_file.h"
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

// Writing.
//
//   write(sample) ──► row in the current chunk ──► full, or flush(): one write(2) ──► file
//
// Data passed to the system survives any end of this program: `kill -9` loses the current chunk, 20
// ms. A power failure loses what the system had not yet written to disk, up to the last half
// minute; there is no fsync, as that stalls the machine. Either way the file is valid up to its
// last complete chunk.

/// For use by one thread. Allocates all memory at construction, except for notes.
class RecordWriter {
public:
    static constexpr std::size_t kMaxNote = std::size_t{1} << 20U; ///< bytes

    /// Creates the file, with its header.
    /// @param header    made by `record_header`
    /// @param policy    whether a file of that name is replaced, once the header is written
    /// @throw InputError if the file exists and is kept, or cannot be written; no file is left
    ///        behind, and an existing one is as it was.
    RecordWriter(const std::filesystem::path &path, const RecordHeader &header,
                 FilePolicy policy = Existing::keep);
    /// Closes and ignores errors; call `close` to get them.
    ~RecordWriter();
    RecordWriter(const RecordWriter &) = delete;
    RecordWriter &operator=(const RecordWriter &) = delete;

    /// Each of these @throw InputError if the disk cannot be written, with the reason and how much
    /// was kept. The file then ends with the last complete chunk and is closed, and all further
    /// calls do nothing.
    void write(const servo::ServoSample &sample);
    /// Ends the current chunk, if it has rows.
    void flush();
    /// Records an event between the last row and the next, as JSON text of up to 1 MB. Ends the
    /// current chunk.
    void note(std::string_view json);
    /// Writes what is still in memory and closes. May be called twice.
    void close();

    [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }
    [[nodiscard]] std::uint64_t rows_in_file() const { return rows_in_file_; }
    [[nodiscard]] std::uint32_t rows_waiting() const { return rows_waiting_; }
    [[nodiscard]] std::uint64_t bytes_in_file() const { return bytes_in_file_; }

private:
    void write_header(std::span<const std::byte> bytes, const std::filesystem::path &file);
    void append(std::span<const std::byte> bytes);
    [[noreturn]] void end_at_last_chunk(int error);

    std::filesystem::path path_;
    int descriptor_ = -1;
    std::uint32_t row_bytes_;
    std::uint32_t chunk_rows_;
    std::vector<std::byte> chunk_; ///< the current chunk: head and rows
    std::uint32_t rows_waiting_ = 0;
    std::uint64_t first_tick_ = 0; ///< of the waiting rows
    std::uint64_t rows_in_file_ = 0;
    std::uint64_t bytes_in_file_ = 0;
};

/// The size of a file of `rows` rows after its header, without notes or chunks that ended early. A
/// recorder on its own thread writes the same, plus the head of a chunk for each pause.
[[nodiscard]] std::uint64_t bytes_of_rows(std::uint64_t rows, const RecordHeader &header);

// Reading, in constant memory.
//
//   RecordReader reader("grasp.rec");
//   reader.for_each([](const ServoSample &sample) { ... });
//   std::cout << reader.ending().text();
//
// Accepts any file. If its writer was killed or it is damaged, it is read up to the first invalid
// chunk; `ending` then reports what was not read, and why.

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
