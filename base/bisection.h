// Bisection: finds the boundary between a value for which a condition holds and one for which it
// fails.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>

namespace springdrive {

/// A value for which the condition holds and one for which it fails; either may be the larger.
struct Bracket {
    double holds_at = 0.0;
    double fails_at = 0.0;

    [[nodiscard]] double middle() const { return 0.5 * (holds_at + fails_at); }
    [[nodiscard]] double width() const { return std::abs(fails_at - holds_at); }
};

/// Halves a bracket until it is narrow enough.
/// @param is_wide  whether a bracket is still too wide
/// @param holds    whether the condition holds for a value
/// @param middle   the point at which a bracket is split, by default its arithmetic mean
template <typename IsWide, typename Holds, typename Middle = decltype(&Bracket::middle)>
[[nodiscard]] Bracket bisect(Bracket bracket, const IsWide &is_wide, const Holds &holds,
                             const Middle &middle = &Bracket::middle) {
    while (is_wide(bracket)) {
        const double value = std::invoke(middle, bracket);
        (holds(value) ? bracket.holds_at : bracket.fails_at) = value;
    }
    return bracket;
}

/// Halves a bracket a given number of times.
template <typename Holds>
[[nodiscard]] Bracket bisect(Bracket bracket, int halvings, const Holds &holds) {
    return bisect(
        bracket, [&](const Bracket &) { return halvings-- > 0; }, holds);
}

/// The last value for which the condition holds, to within `share` of the larger end of the
/// bracket.
template <typename Holds>
[[nodiscard]] double last_that_holds(const Bracket &bracket, double share, const Holds &holds) {
    const auto is_wide = [&](const Bracket &now) {
        return now.width() > share * std::max(std::abs(now.holds_at), std::abs(now.fails_at));
    };
    return bisect(bracket, is_wide, holds).holds_at;
}

} // namespace springdrive
