// The delay d as the amplifier sees it. A command u[k] is applied from (k + d) T to (k + d + 1) T;
// with d = n + f that is, within the period from kT to (k + 1) T,
//
//   u[k − n − 1]  for the first f T,   then   u[k − n]  for the other (1 − f) T.
#pragma once

#include "base/assertions.h"

namespace springdrive::device {

struct SplitDelay {
    int whole = 0;         ///< n
    double fraction = 0.0; ///< f, from 0 to below 1

    /// How many commands a servo must remember at a sample, the one just found not counted: ⌈d⌉.
    [[nodiscard]] constexpr int held() const { return whole + (fraction > 0.0 ? 1 : 0); }
};

/// @pre delay_periods >= 0
[[nodiscard]] constexpr SplitDelay split_delay(double delay_periods) {
    SPRINGDRIVE_ASSERT(delay_periods >= 0.0);
    const int whole = static_cast<int>(delay_periods);
    return {whole, delay_periods - whole}; // exact: leading digits go, none is rounded
}

} // namespace springdrive::device
