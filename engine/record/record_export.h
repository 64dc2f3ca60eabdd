// Exports records for other programs: CSV for spreadsheets, NPY for Python, MAT for MATLAB and
// Octave.
//
// All use the file's own header, so that they also export records of other versions, and read the
// file in pieces. CSV and NPY use constant memory; MAT holds a few columns at a time.
#pragma once

#include "base/new_file.h"
#include "engine/record/record_file.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace springdrive::record {

struct ExportSelection {
    /// Exact names, or prefixes followed by `*`; empty: all columns.
    std::vector<std::string> columns;
    // Inclusive, in the record's time_s; if that is missing, ticks × period.
    double from_s = -std::numeric_limits<double>::infinity();
    double to_s = std::numeric_limits<double>::infinity();
};

struct ExportSummary {
    std::uint64_t rows = 0; ///< exported
    std::size_t columns = 0;
    RecordEnding ending; ///< of the record; its text is to be printed
};

/// The selected columns, in the order of the selection, without duplicates.
/// @throw InputError for a name that matches none, with the closest names.
[[nodiscard]] std::vector<RecordColumn> selected_columns(const RecordHeader &header,
                                                         const std::vector<std::string> &names);

/// Each of these reads the record from its beginning. @throw InputError for an invalid selection,
/// and for an output that cannot be written.

/// Calls take(row) for each row of the selected times, and end_chunk() after each chunk. Returns
/// the number of rows.
std::uint64_t for_each_row(
    RecordReader &record, const ExportSelection &selection,
    const std::function<void(std::span<const std::byte>)> &take,
    const std::function<void()> &end_chunk = [] {});

/// A line of names, then one line per row. Numbers have the fewest digits that read back as the
/// same value; NaN is an empty cell, true is 1.
ExportSummary export_csv(RecordReader &record, const ExportSelection &selection, std::ostream &out);

/// One structured array with a field per column: np.load(file)["tip_x_m"].
ExportSummary export_npy(RecordReader &record, const ExportSelection &selection, std::ostream &out);

/// One variable per column, N×1. An existing file, if it may be replaced, is so only on success.
/// @throw InputError also for more rows than a variable can have, 2 GB.
ExportSummary export_mat(RecordReader &record, const ExportSelection &selection,
                         const std::filesystem::path &file, Existing existing = Existing::keep);

} // namespace springdrive::record
