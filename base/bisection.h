// Bisection: where, between a value that holds and one that does not, that changes.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>

namespace springdrive {

/// A value for which something holds and one for which it does not; either may be the larger.
struct Bracket {
    double holds_at = 0.0;
    double fails_at = 0.0;

    [[nodiscard]] double middle() const { return 0.5 * (holds_at + fails_at); }
    [[nodiscard]] double width() const { return std::abs(fails_at - holds_at); }
};

/// Halves a bracket as long as it is too wide.
/// @param is_wide  whether a bracket is too wide yet
/// @param holds    whether a value does
/// @param middle   of a bracket, if not the arithmetic one
template <typename IsWide, typename Holds, typename Middle = decltype(&Bracket::middle)>
[[nodiscard]] Bracket bisect(Bracket bracket, const IsWide &is_wide, const Holds &holds,
                             const Middle &middle = &Bracket::middle) {
    while (is_wide(bracket)) {
        const double value = std::invoke(middle, bracket);
        (holds(value) ? bracket.holds_at : bracket.fails_at) = value;
    }
    return bracket;
}

/// The same a given number of times.
template <typename Holds>
[[nodiscard]] Bracket bisect(Bracket bracket, int halvings, const Holds &holds) {
    return bisect(
        bracket, [&](const Bracket &) { return halvings-- > 0; }, holds);
}

/// The last value that holds, to a share of the larger end of the bracket.
template <typename Holds>
[[nodiscard]] double last_that_holds(const Bracket &bracket, double share, const Holds &holds) {
    const auto is_wide = [&](const Bracket &now) {
        return now.width() > share * std::max(std::abs(now.holds_at), std::abs(now.fails_at));
    };
    return bisect(bracket, is_wide, holds).holds_at;
}

} // namespace springdrive
