// Writes a record file, chunk by chunk.
//
//   write(sample) ──► row in the current chunk ──► full, or flush(): one write(2) ──► file
//
// Data passed to the system survives any end of this program: `kill -9` loses the current chunk, 20
// ms. A power failure loses what the system had not yet written to disk, up to the last half
// minute; there is no fsync, as that stalls the machine. Either way the file is valid up to its
// last complete chunk.
#pragma once

#include "base/new_file.h"
#include "engine/record/record_format.h"
#include "engine/servo/servo_sample.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

namespace springdrive::record {

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

} // namespace springdrive::record
