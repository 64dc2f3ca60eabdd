#include "engine/record/record_writer.h"

#include "base/input_error.h"
#include "engine/record/record_format.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <span>
#include <string>
#include <system_error>
#include <unistd.h>

namespace springdrive::record {

namespace {

std::string reason(int error) { return std::generic_category().message(error); }

/// Returns errno, or 0 if all was written. A short write is continued; the next call reports the
/// error.
int write_all(int descriptor, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
        if (written < 0 && errno != EINTR) {
            return errno;
        }
        if (written == 0) {
            return ENOSPC;
        }
        if (written > 0) {
            bytes = bytes.subspan(static_cast<std::size_t>(written));
        }
    }
    return 0;
}

int create(const std::filesystem::path &path, Readers readers) {
    const int descriptor =
        ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, creation_mode(readers));
    if (descriptor >= 0) {
        return descriptor;
    }
    if (errno == EEXIST) {
        throw InputError(path.string() + ": exists already; give another name");
    }
    throw InputError(path.string() + ": cannot be written: " + reason(errno) +
                     "; check its folder and permissions");
}

void check_columns(const RecordHeader &header) {
    if (header.columns != sample_columns() || header.chunk_rows == 0) {
        throw InputError("a record cannot be written with the header of another version; "
                         "record_header() makes one");
    }
}

/// The start of the file `path`.
std::vector<std::byte> header_bytes(const RecordHeader &header, const std::filesystem::path &path) {
    const std::string text = to_json(header);
    if (text.size() > kMaxHeaderBytes) {
        throw InputError(path.string() + ": cannot be written: its header, with the device file, "
                                         "is larger than 1 MB; give a smaller device file");
    }
    std::vector<std::byte> bytes(kMagic.size() + 4 + text.size() + 4);
    const std::span inside = std::span(bytes).subspan(kMagic.size() + 4, text.size());
    std::memcpy(bytes.data(), kMagic.data(), kMagic.size());
    store(bytes.data() + kMagic.size(), static_cast<std::uint32_t>(text.size()));
    std::ranges::copy(std::as_bytes(std::span(text)), inside.begin());
    store(bytes.data() + bytes.size() - 4, crc32_of(inside));
    return bytes;
}

} // namespace

RecordWriter::RecordWriter(const std::filesystem::path &path, const RecordHeader &header,
                           FilePolicy policy)
    : path_(path), row_bytes_(header.row_bytes), chunk_rows_(header.chunk_rows) {
    check_columns(header);
    chunk_.resize(kChunkHeadBytes + std::size_t{row_bytes_} * chunk_rows_);
    const std::vector<std::byte> bytes = header_bytes(header, path);
    if (policy.existing == Existing::keep) {
        descriptor_ = create(path, policy.readers);
        write_header(bytes, path);
        return;
    }
    // The old record is there until the new one can be read; the rows follow under its name.
    NewFile file(path, policy.readers);
    descriptor_ = ::open(file.temporary().c_str(), O_WRONLY | O_CLOEXEC);
    write_header(bytes, file.temporary());
    try {
        file.publish(policy.existing);
    } catch (const InputError &) {
        ::close(descriptor_);
        descriptor_ = -1;
        throw;
    }
}

RecordWriter::~RecordWriter() {
    try {
        close();
    } catch (const std::exception &) { // documented: errors are ignored here
        descriptor_ = -1;
    }
}

/// @param file  removed if the disk is full
void RecordWriter::write_header(std::span<const std::byte> bytes,
                                const std::filesystem::path &file) {
    const int error = write_all(descriptor_, bytes);
    if (error != 0) {
        ::close(descriptor_);
        descriptor_ = -1;
        ::unlink(file.c_str());
        throw InputError(path_.string() + ": cannot be written: " + reason(error) +
                         "; nothing was recorded");
    }
    bytes_in_file_ = bytes.size();
}

void RecordWriter::write(const servo::ServoSample &sample) {
    if (!is_open()) {
        return;
    }
    if (rows_waiting_ == 0) {
        first_tick_ = sample.tick;
    }
    encode(sample, chunk_.data() + kChunkHeadBytes + std::size_t{rows_waiting_} * row_bytes_);
    if (++rows_waiting_ == chunk_rows_) {
        flush();
    }
}

void RecordWriter::flush() {
    if (!is_open() || rows_waiting_ == 0) {
        return;
    }
    const std::span bytes =
        std::span(chunk_).first(kChunkHeadBytes + std::size_t{rows_waiting_} * row_bytes_);
    seal_chunk(bytes, ChunkKind::rows, first_tick_, rows_waiting_);
    append(bytes);
    rows_in_file_ += rows_waiting_;
    rows_waiting_ = 0;
}

void RecordWriter::note(std::string_view json) {
    if (json.size() > kMaxNote) {
        throw InputError(path_.string() + ": a note of " + std::to_string(json.size()) +
                         " bytes is too long; notes have up to 1048576");
    }
    flush();
    if (!is_open()) {
        return;
    }
    std::vector<std::byte> bytes(kChunkHeadBytes + json.size());
    std::memcpy(bytes.data() + kChunkHeadBytes, json.data(), json.size());
    seal_chunk(bytes, ChunkKind::note, 0, 0);
    append(bytes);
}

void RecordWriter::close() {
    flush();
    if (!is_open()) {
        return;
    }
    const int result = ::close(descriptor_);
    const int error = errno;
    descriptor_ = -1;
    // Some file systems report a full disk only now.
    if (result != 0 && error != EINTR) {
        throw InputError(path_.string() + ": the end of the recording may be missing: " +
                         reason(error) + "; read it once to see what was kept");
    }
}

void RecordWriter::append(std::span<const std::byte> bytes) {
    const int error = write_all(descriptor_, bytes);
    if (error != 0) {
        end_at_last_chunk(error);
    }
    bytes_in_file_ += bytes.size();
}

void RecordWriter::end_at_last_chunk(int error) {
    // If even this fails, readers still stop at the incomplete chunk.
    [[maybe_unused]] const int result =
        ::ftruncate(descriptor_, static_cast<off_t>(bytes_in_file_));
    ::close(descriptor_);
    descriptor_ = -1;
    rows_waiting_ = 0;
    throw InputError(path_.string() + ": the recording ends after " +
                     std::to_string(rows_in_file_) + " rows, which are kept: " + reason(error) +
                     "; free disk space or choose another folder");
}

std::uint64_t bytes_of_rows(std::uint64_t rows, const RecordHeader &header) {
    const std::uint64_t chunks = (rows + header.chunk_rows - 1) / header.chunk_rows;
    return chunks * kChunkHeadBytes + rows * header.row_bytes;
}

} // namespace springdrive::record
