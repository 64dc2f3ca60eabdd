// Selection of the rows and columns to export.
#pragma once

#include "engine/record/record_export.h"

#include <cmath>
#include <optional>
#include <span>

namespace springdrive::record {

/// Selects the rows of a time range.
class TimeRange {
public:
    /// @throw InputError for a range that ends before it begins, or if rows have no time.
    TimeRange(const RecordHeader &header, const ExportSelection &selection);

    [[nodiscard]] bool holds(std::span<const std::byte> row) const;

private:
    double from_s_;
    double to_s_;
    bool is_all_;
    double period_s_;
    std::optional<std::uint32_t> time_offset_;
    std::optional<std::uint32_t> tick_offset_;
};

/// Reads the record from its beginning; calls take(row) for each row of the range, and end_chunk()
/// after each chunk. Returns the number of rows.
template <typename Take, typename EndChunk>
std::uint64_t for_each_row(RecordReader &record, const TimeRange &range, Take &&take,
                           EndChunk &&end_chunk) {
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

template <typename Take>
std::uint64_t for_each_row(RecordReader &record, const TimeRange &range, Take &&take) {
    return for_each_row(record, range, take, [] {});
}

/// The number of rows in the range.
[[nodiscard]] std::uint64_t count_rows(RecordReader &record, const TimeRange &range);

/// @throw InputError if the stream has failed.
void check_taken(std::ostream &out);

} // namespace springdrive::record
