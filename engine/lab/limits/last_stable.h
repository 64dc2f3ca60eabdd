// Bisection between a value that is stable and one that is not.
#pragma once

#include <algorithm>
#include <cmath>

namespace springdrive::limits {

/// The last stable value between two, to `share` of it.
/// @param holds  whether a value is stable
template <typename Holds>
[[nodiscard]] double last_stable(double stable, double unstable, double share, const Holds &holds) {
    while (std::abs(unstable - stable) > share * std::max(std::abs(stable), std::abs(unstable))) {
        const double middle = 0.5 * (stable + unstable);
        (holds(middle) ? stable : unstable) = middle;
    }
    return stable;
}

} // namespace springdrive::limits
