// Bisection between a value that is stable and one that is not.
#pragma once

#include <algorithm>
#include <cmath>

namespace springdrive {

/// The last stable value between two, to `share` of it; of whole numbers the last itself.
/// @param holds  whether a value is stable
template <typename Holds>
[[nodiscard]] double last_stable(double stable, double unstable, double share, bool whole,
                                 const Holds &holds) {
    const auto apart = [&] { return std::abs(unstable - stable); };
    while (whole ? apart() > 1.0
                 : apart() > share * std::max(std::abs(stable), std::abs(unstable))) {
        const double middle = 0.5 * (stable + unstable);
        const double tried = whole ? std::round(middle) : middle;
        (holds(tried) ? stable : unstable) = tried;
    }
    return stable;
}

} // namespace springdrive
