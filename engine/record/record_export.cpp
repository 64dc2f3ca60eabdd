#include "engine/record/record_export.h"

#include "base/input_error.h"
#include "base/text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <ostream>
#include <string_view>

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

} // namespace springdrive::record
