// Whose turn it is, of series or tracks that are interleaved by chance.
#pragma once

#include "engine/study/methods/random_key.h"

#include <cstddef>
#include <optional>
#include <span>

namespace springdrive::study {

/// Trials ahead of the one that is furthest behind, at the most: a participant cannot tell whose
/// turn it is, and yet a drift in time reaches all alike.
inline constexpr int kMaxLead = 3;

struct Interleaved {
    int trials = 0; ///< so far
    bool is_done = false;
};

/// Drawn from those that are not done and are less than `kMaxLead` trials ahead of the one that
/// is furthest behind; nothing when all are done.
[[nodiscard]] std::optional<std::size_t> next_turn(std::span<const Interleaved> all, RandomKey key);

} // namespace springdrive::study
