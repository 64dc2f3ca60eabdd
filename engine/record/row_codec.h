// Converts a ServoSample to the bytes of a row, and back.
#pragma once

#include "engine/record/record_header.h"
#include "engine/servo/servo_sample.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace springdrive::record {

/// The columns of this version's ServoSample.
[[nodiscard]] std::vector<RecordColumn> sample_columns();

/// Names of the values of its enum columns.
[[nodiscard]] std::map<std::string, std::vector<std::string>> sample_enum_names();

/// @param row  of the length given by `sample_columns`. Does not allocate.
void encode(const servo::ServoSample &sample, std::byte *row);

/// Reads rows of a file whose columns may be in another order, with additional ones in between.
class RowDecoder {
public:
    /// @throw InputError naming the first column that is of another type, or missing though records
    ///        have always had it.
    explicit RowDecoder(const RecordHeader &header);

    /// @param row  of header.row_bytes
    /// @throw InputError for an enum value that this version does not know.
    [[nodiscard]] servo::ServoSample decode(std::span<const std::byte> row) const;

private:
    std::vector<std::uint32_t> offset_; ///< of each column, in the order of `for_each_column`
};

} // namespace springdrive::record
