// Exports a record as comma-separated values.
#include "engine/record/record_export.h"

#include <array>
#include <charconv>
#include <cmath>
#include <ostream>

namespace springdrive::record {

namespace {

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

} // namespace

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
    const auto put_out = [&] {
        out << lines;
        lines.clear();
        check_taken(out);
    };
    const std::uint64_t rows = for_each_row(record, selection, add_line, put_out);
    put_out(); // also of a record without rows
    out.flush();
    check_taken(out);
    return {rows, columns.size(), record.ending()};
}

} // namespace springdrive::record
