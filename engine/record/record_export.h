// Records for other programs: CSV for spreadsheets, NPY for Python, MAT for MATLAB and Octave.
//
// All go by the file's own header, so that they take records of other versions too, and read the
// file in pieces. CSV and NPY keep memory flat; MAT holds some columns at a time.
#pragma once

#include "engine/record/record_reader.h"

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <limits>
#include <string>
#include <vector>

namespace springdrive::record {

struct ExportSelection {
    /// Exact names, or the beginning of names and `*`; empty: all columns.
    std::vector<std::string> columns;
    // Inclusive, in the record's time_s; where that is missing, ticks × period.
    double from_s = -std::numeric_limits<double>::infinity();
    double to_s = std::numeric_limits<double>::infinity();
};

struct ExportSummary {
    std::uint64_t rows = 0; ///< exported
    std::size_t columns = 0;
    RecordEnding ending; ///< of the record; print its text
};

/// In the order of the selection, each once.
/// @throw InputError for a name that fits none, with those that are nearest.
[[nodiscard]] std::vector<RecordColumn> selected_columns(const RecordHeader &header,
                                                         const std::vector<std::string> &names);

/// Each reads the record from its beginning. @throw InputError for a selection that cannot be, and
/// for an output that takes no more.

/// A line of names, then a line a row. Numbers in the fewest digits that read back as the same;
/// NaN is an empty cell, what is true is 1.
ExportSummary export_csv(RecordReader &record, const ExportSelection &selection, std::ostream &out);

/// One structured array, a field a column: np.load(file)["tip_x_m"].
ExportSummary export_npy(RecordReader &record, const ExportSelection &selection, std::ostream &out);

/// One variable a column, N×1. Replaces a file of that name once all is there.
/// @throw InputError too for more rows than a variable can have, 2 GB.
ExportSummary export_mat(RecordReader &record, const ExportSelection &selection,
                         const std::filesystem::path &file);

} // namespace springdrive::record
