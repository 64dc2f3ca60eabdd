// Exports a record as a level 5 MAT file, which MATLAB since 1996, Octave and scipy can read.
#include "engine/record/record_export.h"

#include "base/input_error.h"

#include <matio.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <system_error>

namespace springdrive::record {

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
