// The order of conditions or blocks, by participant number: what comes before something else is
// balanced over participants.
#pragma once

#include "engine/study/methods/random_key.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::study {

enum class Counterbalancing : std::uint8_t {
    fixed, ///< as listed, for everybody
    /// All n! orders in turn; each n consecutive participants together have each condition once in
    /// each place.
    full,
    /// n orders in turn, 2n if n is odd, in which each condition is once (twice) in each place and
    /// is once (twice) directly followed by each other (Williams 1949, Aust. J. Chem. 2, 149).
    balanced_latin_square,
    random, ///< drawn for each participant
};

/// By the number of the kind, as in protocol files.
inline constexpr std::array<std::string_view, 4> kCounterbalancingNames{
    "fixed", "full", "balanced_latin_square", "random"};

/// Of `full`: 720 orders.
inline constexpr int kMaxFullyCounterbalanced = 6;

/// Empty if so many conditions can be ordered so.
[[nodiscard]] std::string validate(Counterbalancing kind, int conditions);

/// The number of participants, or a multiple of it, that balances the orders; 1 if none does.
[[nodiscard]] int participants_to_balance(Counterbalancing kind, int conditions);

/// Conditions 0 to n − 1 in the participant's order.
/// @param participant  counted from 1
/// @param key          of the study, not of the participant; only `random` uses it
[[nodiscard]] std::vector<int> order_of(Counterbalancing kind, int conditions, int participant,
                                        RandomKey key);

} // namespace springdrive::study
