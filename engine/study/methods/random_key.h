// Random values without a state: each is a function of a key, the same on every machine. Keys form
// a tree, such as seed → participant → block → trial, so that a study resumed at any trial draws
// what it would have drawn undisturbed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

namespace springdrive::study {

struct RandomKey {
    std::uint64_t bits = 0;

    friend bool operator==(RandomKey, RandomKey) = default;
};

/// The key of a child; children of one key, and the key itself, are independent.
[[nodiscard]] RandomKey child(RandomKey key, std::uint64_t number);

/// The root of all that a participant is presented.
[[nodiscard]] RandomKey key_of(std::uint64_t seed, int participant);

/// Uniform in [0, 1), 53 bits.
[[nodiscard]] double uniform(RandomKey key);

/// Normal, with mean 0 and deviation 1.
[[nodiscard]] double standard_normal(RandomKey key);

/// Uniform in 0 to count − 1. @pre count >= 1
[[nodiscard]] std::size_t below(RandomKey key, std::size_t count);

/// Puts the values into an order by chance; all orders are equally likely (Fisher-Yates).
template <typename T> void shuffle(RandomKey key, std::span<T> values) {
    for (std::size_t left = values.size(); left > 1; --left) {
        std::swap(values[left - 1], values[below(child(key, left), left)]);
    }
}

// Whose turn it is, of series or tracks that are interleaved by chance.

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
