// CVODE's two families of methods.
#pragma once

#include <cstdint>

namespace springdrive::charts {

enum class CvodeMethod : std::uint8_t {
    adams, ///< up to order 12, for non-stiff problems
    bdf,   ///< up to order 5, for stiff problems
};

} // namespace springdrive::charts
