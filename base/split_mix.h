// SplitMix64 (Steele, Lea & Flood 2014, "Fast splittable pseudorandom number generators"): random
// bits that are the same on every machine.
#pragma once

#include <cstdint>

namespace springdrive::split_mix {

/// What the generator's state is advanced by: 2⁶⁴ over the golden ratio, odd.
inline constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15U;

/// The output function: a bijection that scatters every bit over all of them. RT-safe.
[[nodiscard]] constexpr std::uint64_t scattered(std::uint64_t bits) noexcept {
    bits = (bits ^ (bits >> 30U)) * 0xbf58476d1ce4e5b9U;
    bits = (bits ^ (bits >> 27U)) * 0x94d049bb133111ebU;
    return bits ^ (bits >> 31U);
}

/// Uniform in [0, 1), from the upper 53 bits. RT-safe.
[[nodiscard]] constexpr double unit_share(std::uint64_t bits) noexcept {
    return static_cast<double>(bits >> 11U) * 0x1p-53;
}

/// The value of that number, from 0, of the generator that starts at `seed`. RT-safe.
[[nodiscard]] constexpr std::uint64_t value(std::uint64_t seed, std::uint64_t number) noexcept {
    return scattered(seed + (number + 1) * kStep);
}

} // namespace springdrive::split_mix
