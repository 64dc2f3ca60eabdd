// Four floats that are computed together, by the vector extension that GCC and Clang share: the
// same source on every processor, one instruction for each operation where the processor has it.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#ifdef __SSE__
#include <xmmintrin.h>
#endif

namespace springdrive::contact {

using Float4 = float __attribute__((vector_size(16)));

/// What a comparison of two Float4 gives: all bits of a lane set, or none.
using Mask4 = std::int32_t __attribute__((vector_size(16)));

[[nodiscard]] inline Float4 all_lanes(float value) noexcept {
    return Float4{value, value, value, value};
}

// Lane by lane. Where one of the two is not a number, the second is taken.
[[nodiscard]] inline Float4 smaller_portably(Float4 a, Float4 b) noexcept { return a < b ? a : b; }
[[nodiscard]] inline Float4 larger_portably(Float4 a, Float4 b) noexcept { return a > b ? a : b; }

/// Bit i is the highest bit of lane i.
[[nodiscard]] inline unsigned lane_bits_portably(Mask4 mask) noexcept {
    const auto lanes = std::bit_cast<std::array<std::uint32_t, 4>>(mask);
    return lanes[0] >> 31U | lanes[1] >> 31U << 1U | lanes[2] >> 31U << 2U | lanes[3] >> 31U << 3U;
}

// The same, where the compiler has to be told which instruction does it.
#ifdef __SSE__
[[nodiscard]] inline Float4 smaller(Float4 a, Float4 b) noexcept { return _mm_min_ps(a, b); }
[[nodiscard]] inline Float4 larger(Float4 a, Float4 b) noexcept { return _mm_max_ps(a, b); }
[[nodiscard]] inline unsigned lane_bits(Mask4 mask) noexcept {
    return static_cast<unsigned>(_mm_movemask_ps(std::bit_cast<__m128>(mask)));
}
#else
[[nodiscard]] inline Float4 smaller(Float4 a, Float4 b) noexcept { return smaller_portably(a, b); }
[[nodiscard]] inline Float4 larger(Float4 a, Float4 b) noexcept { return larger_portably(a, b); }
[[nodiscard]] inline unsigned lane_bits(Mask4 mask) noexcept { return lane_bits_portably(mask); }
#endif

} // namespace springdrive::contact
