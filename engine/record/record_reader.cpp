#include "engine/record/record_reader.h"

#include "base/input_error.h"

#include <array>
#include <cstring>
#include <system_error>

namespace springdrive::record {

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
