// CVODE's two families of methods.
#pragma once

#include <cstdint>

namespace springdrive::charts {

enum class CvodeMethod : std::uint8_t {
    adams, ///< up to order 12, for what is not stiff
    bdf,   ///< up to order 5, for what is stiff
};

} // namespace springdrive::charts
