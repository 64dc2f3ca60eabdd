#include "engine/record/record_file.h"

#include "base/input_error.h"
#include "engine/record/record_format.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <span>
#include <string>
#include <system_error>

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

/// Whether a file that is being written has lost its name, by itself or with its folder: then all
/// that is written is lost with it.
bool is_gone(const std::filesystem::path &path, int descriptor) {
    struct stat named {};
    struct stat written {};
    if (::stat(path.c_str(), &named) != 0) {
        return errno == ENOENT || errno == ENOTDIR;
    }
    return ::fstat(descriptor, &written) == 0 && written.st_nlink == 0;
}

std::string gone_text(const std::filesystem::path &path) {
    return path.string() +
           ": the recording ends: the file is not there any more, as it or its folder "
           "was deleted or moved; record to another folder";
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
    const bool was_gone = is_gone(path_, descriptor_);
    const int result = ::close(descriptor_);
    const int error = errno;
    descriptor_ = -1;
    if (was_gone) {
        throw InputError(gone_text(path_));
    }
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
    if (is_gone(path_, descriptor_)) {
        ::close(descriptor_);
        descriptor_ = -1;
        rows_waiting_ = 0;
        throw InputError(gone_text(path_));
    }
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

namespace {

std::size_t size_of_file(const std::filesystem::path &path) {
    std::error_code error;
    const bool is_file = std::filesystem::is_regular_file(path, error);
    const std::uintmax_t bytes = is_file ? std::filesystem::file_size(path, error) : 0;
    if (!is_file || error) {
        throw InputError(path.string() + ": cannot be read: " +
                         (error ? error.message() : std::string("it is not a regular file")) +
                         "; check its name and permissions");
    }
    return bytes;
}

std::string counted(std::uint64_t count, const std::string &what) {
    return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

} // namespace

std::string RecordEnding::text() const {
    std::string line = counted(rows, "row");
    if (notes > 0) {
        line += ", " + counted(notes, "note");
    }
    if (missing_ticks > 0) {
        line += "; " + counted(missing_ticks, "sample") + " lost between them";
    }
    if (!why.empty()) {
        line +=
            "; the last " + counted(unusable_bytes, "byte") + " of the file cannot be used: " + why;
    }
    return line;
}

RecordReader::RecordReader(const std::filesystem::path &path) : path_(path) {
    file_bytes_ = size_of_file(path);
    stream_.open(path, std::ios::binary);
    if (!stream_) {
        throw InputError(path.string() + ": cannot be read; check its permissions");
    }
    try {
        read_header();
    } catch (const InputError &error) {
        throw InputError(path.string() + ": " + error.what());
    }
    const RecordColumn *const tick = header_.column("tick");
    if (tick != nullptr && tick->type == ColumnType::u64) {
        tick_offset_ = tick->offset;
    }
    rewind();
}

void RecordReader::read_header() {
    std::array<std::byte, kMagic.size() + 4> start{};
    const std::size_t magic_but_version = kMagic.size() - 1;
    if (!read_exactly(start) || std::memcmp(start.data(), kMagic.data(), magic_but_version) != 0) {
        throw InputError("is not a springdrive record; give a file made by `springdrive record`");
    }
    if (static_cast<char>(start[magic_but_version]) != kMagic.back()) {
        throw InputError("is a record in a layout that this version does not know; read it with "
                         "the version that wrote it");
    }
    const auto length = load<std::uint32_t>(start.data() + kMagic.size());
    if (length > kMaxHeaderBytes || start.size() + length + 4 > file_bytes_) {
        throw InputError("its header is incomplete or damaged; nothing in the file can be used");
    }
    std::vector<std::byte> json(length + std::size_t{4});
    if (!read_exactly(json) ||
        load<std::uint32_t>(json.data() + length) != crc32_of(std::span(json).first(length))) {
        throw InputError("its header is damaged (CRC); nothing in the file can be used");
    }
    header_ = from_json({reinterpret_cast<const char *>(json.data()), length});
    first_chunk_at_ = start.size() + json.size();
}

void RecordReader::rewind() {
    stream_.clear();
    stream_.seekg(static_cast<std::streamoff>(first_chunk_at_));
    position_ = first_chunk_at_;
    rows_ = 0;
    is_note_ = false;
    at_end_ = false;
    last_tick_.reset();
    ending_ = {};
}

bool RecordReader::read_exactly(std::span<std::byte> bytes) {
    stream_.read(reinterpret_cast<char *>(bytes.data()),
                 static_cast<std::streamsize>(bytes.size()));
    return static_cast<std::size_t>(stream_.gcount()) == bytes.size();
}

void RecordReader::stop(const std::string &why) {
    at_end_ = true;
    rows_ = 0;
    is_note_ = false;
    ending_.why = why;
    ending_.unusable_bytes = why.empty() ? 0 : file_bytes_ - position_;
}

/// What is wrong with a chunk according to its head, if `left` bytes follow it in the file.
std::string RecordReader::error(const ChunkHead &head, std::uint64_t left) const {
    if (head.payload_bytes > kMaxPayloadBytes) {
        return "a chunk's size exceeds the maximum";
    }
    if (head.kind == static_cast<std::uint32_t>(ChunkKind::rows) &&
        (head.rows == 0 || head.rows > header_.chunk_rows ||
         std::uint64_t{head.rows} * header_.row_bytes != head.payload_bytes)) {
        return "a chunk's size does not match its rows";
    }
    return head.payload_bytes > left ? "the last chunk is incomplete" : "";
}

/// Reads and checks one chunk of any kind.
bool RecordReader::read_chunk(ChunkHead &head) {
    const std::uint64_t left = file_bytes_ - position_;
    std::array<std::byte, kChunkHeadBytes> bytes{};
    if (left < kChunkHeadBytes || !read_exactly(bytes)) {
        stop(left == 0 ? "" : "the last chunk is incomplete");
        return false;
    }
    std::memcpy(static_cast<void *>(&head), bytes.data(), bytes.size());
    if (head.magic != ChunkHead{}.magic) {
        stop("there is no chunk where one should begin");
        return false;
    }
    const std::string wrong = error(head, left - kChunkHeadBytes);
    if (!wrong.empty()) {
        stop(wrong);
        return false;
    }
    payload_.resize(head.payload_bytes);
    if (!read_exactly(payload_)) {
        stop("the file cannot be read further");
        return false;
    }
    const auto before_crc = std::span(bytes).first(offsetof(ChunkHead, crc));
    if (crc32_of(payload_, crc32_of(before_crc)) != head.crc) {
        stop("a chunk is damaged (CRC)");
        return false;
    }
    position_ += kChunkHeadBytes + head.payload_bytes;
    return true;
}

bool RecordReader::next() {
    ChunkHead head;
    while (!at_end_ && read_chunk(head)) {
        is_note_ = head.kind == static_cast<std::uint32_t>(ChunkKind::note);
        rows_ = 0;
        if (is_note_) {
            ++ending_.notes;
            return true;
        }
        if (head.kind == static_cast<std::uint32_t>(ChunkKind::rows)) {
            take_rows(head.rows);
            return true;
        }
    }
    return false;
}

void RecordReader::take_rows(std::uint32_t rows) {
    rows_ = rows;
    ending_.rows += rows;
    for (std::uint32_t i = 0; tick_offset_ && i < rows; ++i) {
        const auto tick = load<std::uint64_t>(row(i).data() + *tick_offset_);
        if (last_tick_ && tick > *last_tick_) {
            ending_.missing_ticks += tick - *last_tick_ - 1;
        }
        last_tick_ = tick;
    }
}

std::span<const std::byte> RecordReader::row(std::uint32_t number) const {
    return std::span(payload_).subspan(std::size_t{number} * header_.row_bytes, header_.row_bytes);
}

std::string_view RecordReader::note() const {
    return is_note_
               ? std::string_view(reinterpret_cast<const char *>(payload_.data()), payload_.size())
               : std::string_view();
}

servo::ServoSample RecordReader::read_sample(std::uint32_t number) {
    try {
        if (!decoder_) {
            decoder_.emplace(header_);
        }
        return decoder_->decode(row(number));
    } catch (const InputError &error) {
        throw InputError(path_.string() + ": " + error.what());
    }
}

} // namespace springdrive::record
