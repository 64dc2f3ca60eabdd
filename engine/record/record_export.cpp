#include "engine/record/record_export.h"

#include "base/input_error.h"
#include "base/text.h"

#include <matio.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <ostream>
#include <string_view>
#include <system_error>

namespace springdrive::record {

namespace {

constexpr std::size_t kMaxSuggestions = 3;

constexpr double kRounding = 1e-6; ///< tolerance of a range's bounds, in periods

std::string nearest_names(const RecordHeader &header, std::string_view name) {
    std::vector<const RecordColumn *> columns;
    for (const RecordColumn &column : header.columns) {
        columns.push_back(&column);
    }
    sort_by_similarity(columns, name,
                       [](const RecordColumn *column) { return std::string_view(column->name); });
    std::string list;
    for (std::size_t i = 0; i < std::min(kMaxSuggestions, columns.size()); ++i) {
        list += (i == 0 ? "" : ", ") + columns[i]->name;
    }
    return list;
}

[[noreturn]] void refuse(const RecordHeader &header, const std::string &name) {
    const bool is_prefix = !name.empty() && name.back() == '*';
    throw InputError(
        (is_prefix ? "no column of the record matches " : "the record has no column ") + name +
        "; the closest are " + nearest_names(header, name));
}

/// The rows of a time range.
class TimeRange {
public:
    /// @throw InputError for a range that ends before it begins, or if rows have no time.
    TimeRange(const RecordHeader &header, const ExportSelection &selection)
        : from_s_(selection.from_s), to_s_(selection.to_s), period_s_(header.period_s) {
        if (!(from_s_ <= to_s_)) {
            throw InputError("a range from " + std::to_string(from_s_) + " to " +
                             std::to_string(to_s_) + " s is empty; give its start first");
        }
        // tick × T is rounded: at 1 kHz the tick at 1.009 s has the time 1.0090000000000001.
        from_s_ -= kRounding * period_s_;
        to_s_ += kRounding * period_s_;
        is_all_ = std::isinf(from_s_) && from_s_ < 0.0 && std::isinf(to_s_) && to_s_ > 0.0;
        const RecordColumn *const time = header.column("time_s");
        const RecordColumn *const tick = header.column("tick");
        if (time != nullptr && time->type == ColumnType::f64) {
            time_offset_ = time->offset;
        } else if (tick != nullptr && tick->type == ColumnType::u64) {
            tick_offset_ = tick->offset;
        } else if (!is_all_) {
            throw InputError("the record has neither time_s nor tick, so no time range can be "
                             "selected; export all of it");
        }
    }

    [[nodiscard]] bool holds(std::span<const std::byte> row) const {
        if (is_all_) {
            return true;
        }
        const double time_s =
            time_offset_
                ? load<double>(row.data() + *time_offset_)
                : static_cast<double>(load<std::uint64_t>(row.data() + *tick_offset_)) * period_s_;
        return time_s >= from_s_ && time_s <= to_s_;
    }

private:
    double from_s_;
    double to_s_;
    bool is_all_;
    double period_s_;
    std::optional<std::uint32_t> time_offset_;
    std::optional<std::uint32_t> tick_offset_;
};

/// @throw InputError if the stream has failed.
void put_out(std::ostream &out, std::string &bytes) {
    out << bytes;
    bytes.clear();
    if (!out) {
        throw InputError(
            "the export is incomplete: its output cannot be written; free disk space or choose "
            "another folder");
    }
}

/// Also of a record without rows.
void end_output(std::ostream &out, std::string &bytes) {
    put_out(out, bytes);
    out.flush();
    put_out(out, bytes);
}

template <typename Number> void append_number(std::string &line, const std::byte *from) {
    const auto number = load<Number>(from);
    std::array<char, 32> digits{};
    line.append(digits.begin(), std::to_chars(digits.begin(), digits.end(), number).ptr);
}

void append_cell(std::string &line, ColumnType type, const std::byte *from) {
    switch (type) {
    case ColumnType::u8:
        return append_number<std::uint8_t>(line, from);
    case ColumnType::u16:
        return append_number<std::uint16_t>(line, from);
    case ColumnType::u32:
        return append_number<std::uint32_t>(line, from);
    case ColumnType::u64:
        return append_number<std::uint64_t>(line, from);
    case ColumnType::i32:
        return append_number<std::int32_t>(line, from);
    case ColumnType::f64:
        break;
    }
    if (!std::isnan(load<double>(from))) {
        append_number<double>(line, from);
    }
}

// A NumPy file: a header in Python syntax, then the packed rows.
//
//   "\x93NUMPY" 1 0, u16 length, {'descr': [('tick', '<u8'), ...], ... 'shape': (N,), }, rows
//
// Version 2 has a u32 length, for headers above 64 KB.

constexpr std::string_view kNumpyMagic = "\x93NUMPY";
constexpr std::size_t kAlignment = 64; ///< of the rows in the file

/// Starts `before` bytes into the file and is padded with blanks up to the alignment.
std::string description(const std::vector<RecordColumn> &columns, std::uint64_t rows,
                        std::size_t before) {
    std::string text = "{'descr': [";
    for (const RecordColumn &column : columns) {
        // Names are letters, digits and _: nothing to quote.
        text += "('" + column.name + "', '" + std::string(code_of(column.type)) + "'), ";
    }
    text += "], 'fortran_order': False, 'shape': (" + std::to_string(rows) + ",), }";
    text.append(kAlignment - 1 - (before + text.size()) % kAlignment, ' ');
    return text + '\n';
}

std::string npy_header(const std::vector<RecordColumn> &columns, std::uint64_t rows) {
    for (const char version : {'\x01', '\x02'}) {
        const std::size_t length_bytes = version == 1 ? 2 : 4;
        const std::size_t before = kNumpyMagic.size() + 2 + length_bytes;
        const std::string text = description(columns, rows, before);
        if (version == 2 || text.size() <= 0xFFFF) {
            const auto length = static_cast<std::uint32_t>(text.size());
            std::string header(kNumpyMagic);
            header += {version, '\0'};
            for (std::size_t i = 0; i < length_bytes; ++i) {
                header += static_cast<char>(length >> (8 * i) & 0xFFU);
            }
            return header + text;
        }
    }
    return {}; // not reached
}

} // namespace

std::vector<RecordColumn> selected_columns(const RecordHeader &header,
                                           const std::vector<std::string> &names) {
    if (names.empty()) {
        return header.columns;
    }
    std::vector<RecordColumn> selected;
    for (const std::string &name : names) {
        const bool is_prefix = !name.empty() && name.back() == '*';
        const std::string_view beginning(name.data(), name.size() - (is_prefix ? 1 : 0));
        bool fits_any = false;
        for (const RecordColumn &column : header.columns) {
            if (is_prefix ? column.name.starts_with(beginning) : column.name == name) {
                fits_any = true;
                if (std::find(selected.begin(), selected.end(), column) == selected.end()) {
                    selected.push_back(column);
                }
            }
        }
        if (!fits_any) {
            refuse(header, name);
        }
    }
    return selected;
}

std::uint64_t for_each_row(RecordReader &record, const ExportSelection &selection,
                           const std::function<void(std::span<const std::byte>)> &take,
                           const std::function<void()> &end_chunk) {
    const TimeRange range(record.header(), selection);
    std::uint64_t taken = 0;
    record.rewind();
    while (record.next()) {
        for (std::uint32_t i = 0; i < record.rows(); ++i) {
            if (range.holds(record.row(i))) {
                ++taken;
                take(record.row(i));
            }
        }
        end_chunk();
    }
    return taken;
}

ExportSummary export_csv(RecordReader &record, const ExportSelection &selection,
                         std::ostream &out) {
    const auto columns = selected_columns(record.header(), selection.columns);
    std::string lines;
    for (const RecordColumn &column : columns) {
        lines += (lines.empty() ? "" : ",") + column.name;
    }
    lines += '\n';
    const auto add_line = [&](std::span<const std::byte> row) {
        for (const RecordColumn &column : columns) {
            append_cell(lines, column.type, row.data() + column.offset);
            lines += ',';
        }
        lines.back() = '\n';
    };
    const std::uint64_t rows =
        for_each_row(record, selection, add_line, [&] { put_out(out, lines); });
    end_output(out, lines);
    return {rows, columns.size(), record.ending()};
}

ExportSummary export_npy(RecordReader &record, const ExportSelection &selection,
                         std::ostream &out) {
    const auto columns = selected_columns(record.header(), selection.columns);
    // The count precedes the rows, and the output may not be seekable.
    const std::uint64_t announced = for_each_row(record, selection, [](auto) {});
    std::string bytes = npy_header(columns, announced);
    const auto add_row = [&](std::span<const std::byte> row) {
        for (const RecordColumn &column : columns) {
            bytes.append(reinterpret_cast<const char *>(row.data() + column.offset),
                         bytes_of(column.type));
        }
    };
    const std::uint64_t rows =
        for_each_row(record, selection, add_row, [&] { put_out(out, bytes); });
    end_output(out, bytes);
    return {rows, columns.size(), record.ending()};
}

// Exports a record as a level 5 MAT file, which MATLAB since 1996, Octave and scipy can read.

namespace {

constexpr std::uint64_t kMaxBytesPerVariable = std::numeric_limits<std::int32_t>::max();
/// Limit on the columns held in memory at a time; a single column may exceed it.
constexpr std::uint64_t kBytesAtATime = 256U << 20U;
constexpr const char *kTitle = "MATLAB 5.0 MAT-file, telemetry recorded by springdrive";

struct CloseMat {
    void operator()(mat_t *mat) const { Mat_Close(mat); }
};
struct FreeVariable {
    void operator()(matvar_t *variable) const { Mat_VarFree(variable); }
};

struct MatType {
    matio_classes of_array;
    matio_types of_data;
};

/// Indexed by ColumnType.
constexpr std::array<MatType, 6> kMatTypes{{{MAT_C_UINT8, MAT_T_UINT8},
                                            {MAT_C_UINT16, MAT_T_UINT16},
                                            {MAT_C_UINT32, MAT_T_UINT32},
                                            {MAT_C_UINT64, MAT_T_UINT64},
                                            {MAT_C_INT32, MAT_T_INT32},
                                            {MAT_C_DOUBLE, MAT_T_DOUBLE}}};

constexpr std::uint64_t in_eights(std::uint64_t bytes) { return (bytes + 7) / 8 * 8; }

/// Minimum size of a variable in the file: tags, flags, dimensions, name and numbers.
std::uint64_t bytes_in_file(const RecordColumn &column, std::uint64_t rows) {
    const std::uint64_t name = column.name.size() <= 4 ? 0 : in_eights(column.name.size());
    const std::uint64_t numbers = rows * bytes_of(column.type);
    return 48 + name + 8 + (numbers <= 4 ? 0 : in_eights(numbers));
}

void check_sizes(const std::vector<RecordColumn> &columns, std::uint64_t rows) {
    for (const RecordColumn &column : columns) {
        if (rows > kMaxBytesPerVariable / bytes_of(column.type)) {
            throw InputError("column " + column.name + " has " + std::to_string(rows) +
                             " rows, but a variable in a MAT file is limited to 2 GB; export a "
                             "shorter time range, or to NPY");
        }
    }
}

using Numbers = std::vector<std::byte>;

/// For each of `columns` its values in all rows of the range.
std::vector<Numbers> read_columns(RecordReader &record, const ExportSelection &selection,
                                  std::span<const RecordColumn> columns, std::uint64_t rows) {
    std::vector<Numbers> numbers(columns.size());
    for (std::size_t i = 0; i < columns.size(); ++i) {
        numbers[i].reserve(rows * bytes_of(columns[i].type));
    }
    for_each_row(record, selection, [&](std::span<const std::byte> row) {
        for (std::size_t i = 0; i < columns.size(); ++i) {
            const auto cell = row.subspan(columns[i].offset, bytes_of(columns[i].type));
            numbers[i].insert(numbers[i].end(), cell.begin(), cell.end());
        }
    });
    return numbers;
}

bool write_variable(mat_t *mat, const RecordColumn &column, Numbers &numbers) {
    const MatType type = kMatTypes[static_cast<std::size_t>(column.type)];
    std::array<std::size_t, 2> size{numbers.size() / bytes_of(column.type), 1};
    const std::unique_ptr<matvar_t, FreeVariable> variable(
        Mat_VarCreate(column.name.c_str(), type.of_array, type.of_data, 2, size.data(),
                      numbers.data(), MAT_F_DONT_COPY_DATA));
    return variable && Mat_VarWrite(mat, variable.get(), MAT_COMPRESSION_NONE) == 0;
}

/// False if the file could not be written.
bool write_variables(RecordReader &record, const ExportSelection &selection, std::uint64_t rows,
                     std::span<const RecordColumn> columns, const std::filesystem::path &file) {
    const std::unique_ptr<mat_t, CloseMat> mat(Mat_CreateVer(file.c_str(), kTitle, MAT_FT_MAT5));
    const std::uint64_t widest = std::max<std::uint64_t>(rows * sizeof(double), 1);
    const auto at_a_time =
        static_cast<std::size_t>(std::max<std::uint64_t>(kBytesAtATime / widest, 1));
    bool is_good = mat != nullptr;
    while (is_good && !columns.empty()) {
        const auto now = columns.first(std::min(at_a_time, columns.size()));
        std::vector<Numbers> numbers = read_columns(record, selection, now, rows);
        for (std::size_t i = 0; is_good && i < now.size(); ++i) {
            is_good = write_variable(mat.get(), now[i], numbers[i]);
        }
        columns = columns.subspan(now.size());
    }
    return is_good;
}

} // namespace

ExportSummary export_mat(RecordReader &record, const ExportSelection &selection,
                         const std::filesystem::path &file, Existing existing) {
    const auto columns = selected_columns(record.header(), selection.columns);
    const std::uint64_t rows = for_each_row(record, selection, [](auto) {});
    const ExportSummary summary{rows, columns.size(), record.ending()};
    check_sizes(columns, rows);
    std::uint64_t min_bytes = 128; // the file's header
    for (const RecordColumn &column : columns) {
        min_bytes += bytes_in_file(column, rows);
    }
    NewFile written(file);
    std::error_code error;
    // The library does not report a full disk; the file's size shows it.
    if (!write_variables(record, selection, rows, columns, written.temporary()) ||
        std::filesystem::file_size(written.temporary(), error) < min_bytes || error) {
        throw InputError(file.string() + ": cannot be written; check its folder, permissions and "
                                         "free disk space");
    }
    written.publish(existing);
    return summary;
}

} // namespace springdrive::record
