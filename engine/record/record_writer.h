// Writes a record file, chunk by chunk.
//
//   write(sample) ──► row in the chunk under way ──► full, or flush(): one write(2) ──► file
//
// What was handed to the system survives the end of this program, however it ends: `kill -9` loses
// the chunk under way, 20 ms. A power cut loses what the system had not put on the disk yet, which
// may be the last half minute; it is not asked to hurry, as that stalls the machine. Either way the
// file is good up to its last whole chunk.
#pragma once

#include "engine/record/record_header.h"
#include "engine/servo/servo_sample.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

namespace springdrive::record {

/// Of one thread. All its memory is allocated at once, but for notes.
class RecordWriter {
public:
    static constexpr std::size_t kLongestNote = std::size_t{1} << 20U; ///< bytes

    /// Creates the file, with its header.
    /// @param header  of `record_header`
    /// @throw InputError where the file exists already or cannot be written: none is left behind.
    RecordWriter(const std::filesystem::path &path, const RecordHeader &header);
    /// Closes, and says nothing of what fails; call `close` to know.
    ~RecordWriter();
    RecordWriter(const RecordWriter &) = delete;
    RecordWriter &operator=(const RecordWriter &) = delete;

    /// Each of these @throw InputError where the disk takes no more, with the reason and how much
    /// was kept. The file then ends with the last whole chunk, is closed, and all further calls do
    /// nothing.
    void write(const servo::ServoSample &sample);
    /// Ends the chunk under way, if it has rows.
    void flush();
    /// Something that happened between the last row and the next, as JSON text of up to 1 MB.
    /// Ends the chunk under way.
    void note(std::string_view json);
    /// Writes out what is still in memory. Harmless twice.
    void close();

    [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }
    [[nodiscard]] std::uint64_t rows_in_file() const { return rows_in_file_; }
    [[nodiscard]] std::uint32_t rows_waiting() const { return rows_waiting_; }
    [[nodiscard]] std::uint64_t bytes_in_file() const { return bytes_in_file_; }

private:
    void write_header(const RecordHeader &header);
    void append(std::span<const std::byte> bytes);
    void drop_file() noexcept;
    [[noreturn]] void end_at_last_chunk(int error);

    std::filesystem::path path_;
    int descriptor_ = -1;
    std::uint32_t row_bytes_;
    std::uint32_t chunk_rows_;
    std::vector<std::byte> chunk_; ///< head and rows under way
    std::uint32_t rows_waiting_ = 0;
    std::uint64_t first_tick_ = 0; ///< of those
    std::uint64_t rows_in_file_ = 0;
    std::uint64_t bytes_in_file_ = 0;
};

/// The size of a file of `rows` rows written without notes or early ends of chunks. What a recorder
/// writes on its own thread is as large, but for the head of a chunk at each pause.
[[nodiscard]] std::uint64_t expected_bytes(std::uint64_t rows, const RecordHeader &header);

} // namespace springdrive::record
