// The delay d, split into whole periods and a fraction. A command u[k] is applied from (k + d) T to
// (k + d + 1) T; with d = n + f this means, within the period from kT to (k + 1) T,
//
//   u[k − n − 1]  for the first f T,   then   u[k − n]  for the other (1 − f) T.
#pragma once

#include "base/assertions.h"

namespace springdrive::device {

struct SplitDelay {
    int whole = 0;         ///< n
    double fraction = 0.0; ///< f, from 0 to below 1

    /// How many past commands a servo must store at a sample, excluding the newest: ⌈d⌉.
    [[nodiscard]] constexpr int held() const { return whole + (fraction > 0.0 ? 1 : 0); }
};

/// @pre delay_periods >= 0
[[nodiscard]] constexpr SplitDelay split_delay(double delay_periods) {
    SPRINGDRIVE_ASSERT(delay_periods >= 0.0);
    const int whole = static_cast<int>(delay_periods);
    return {whole, delay_periods - whole}; // exact: the subtraction rounds nothing
}

} // namespace springdrive::device
