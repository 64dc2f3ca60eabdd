// A ServoSample to the bytes of a row, and back.
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

/// Of this version's ServoSample.
[[nodiscard]] std::vector<RecordColumn> sample_columns();

/// What the numbers of its columns stand for.
[[nodiscard]] std::map<std::string, std::vector<std::string>> sample_enum_names();

/// @param row  as long as `sample_columns` say. Allocates nothing.
void encode(const servo::ServoSample &sample, std::byte *row);

/// Reads rows of a file whose columns may stand in another order, with others between them.
class RowDecoder {
public:
    /// @throw InputError naming the first column that is missing or of another type.
    explicit RowDecoder(const RecordHeader &header);

    /// @param row  of header.row_bytes
    /// @throw InputError for an enum's number that this version does not know.
    [[nodiscard]] servo::ServoSample decode(std::span<const std::byte> row) const;

private:
    std::vector<std::uint32_t> offset_; ///< of each column, in the order of the list
};

} // namespace springdrive::record
