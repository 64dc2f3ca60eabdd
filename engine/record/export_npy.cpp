// Exports a record as a NumPy file: a header in Python syntax, then the packed rows.
//
//   "\x93NUMPY" 1 0, u16 length, {'descr': [('tick', '<u8'), ...], ... 'shape': (N,), }, rows
//
// Version 2 has a u32 length, for headers above 64 KB.
#include "engine/record/record_export.h"

#include <cstring>
#include <ostream>

namespace springdrive::record {

namespace {

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

ExportSummary export_npy(RecordReader &record, const ExportSelection &selection,
                         std::ostream &out) {
    const auto columns = selected_columns(record.header(), selection.columns);
    // The count precedes the rows, and the output may not be seekable.
    const std::uint64_t announced = for_each_row(record, selection, [](auto) {});
    out << npy_header(columns, announced);
    std::string bytes;
    const auto add_row = [&](std::span<const std::byte> row) {
        for (const RecordColumn &column : columns) {
            bytes.append(reinterpret_cast<const char *>(row.data() + column.offset),
                         bytes_of(column.type));
        }
    };
    const auto put_out = [&] {
        out << bytes;
        bytes.clear();
        check_taken(out);
    };
    const std::uint64_t rows = for_each_row(record, selection, add_row, put_out);
    out.flush();
    check_taken(out);
    return {rows, columns.size(), record.ending()};
}

} // namespace springdrive::record
