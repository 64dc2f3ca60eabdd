// The node of a BoxTree: eight boxes side by side, tested four at a time.
//
// Eight rather than four: a search is bound by the latency of loading one node to find the next, so
// fewer and larger steps are faster (10 to 30 % less time, measured) and need less memory.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#ifdef __SSE__
#include <xmmintrin.h>
#endif

namespace springdrive::contact {

// Four floats computed together, by the vector extension that GCC and Clang share: the same source
// on every processor, one instruction for each operation where the processor has it.
using Float4 = float __attribute__((vector_size(16)));

/// What a comparison of two Float4 gives: all bits of a lane set, or none.
using Mask4 = std::int32_t __attribute__((vector_size(16)));

[[nodiscard]] inline Float4 all_lanes(float value) noexcept {
    return Float4{value, value, value, value};
}

// Lane by lane. Where one of the two is not a number, the result is the second.
[[nodiscard]] inline Float4 smaller_portably(Float4 a, Float4 b) noexcept { return a < b ? a : b; }
[[nodiscard]] inline Float4 larger_portably(Float4 a, Float4 b) noexcept { return a > b ? a : b; }

/// Bit i is the highest bit of lane i.
[[nodiscard]] inline unsigned lane_bits_portably(Mask4 mask) noexcept {
    const auto lanes = std::bit_cast<std::array<std::uint32_t, 4>>(mask);
    return lanes[0] >> 31U | lanes[1] >> 31U << 1U | lanes[2] >> 31U << 2U | lanes[3] >> 31U << 3U;
}

// The same by intrinsics, where the compiler does not find the instruction itself.
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

/// The content of a box: another node or an item.
class BoxChild {
public:
    BoxChild() = default; ///< unset, so that nodes need not be written twice
    [[nodiscard]] static constexpr BoxChild node(std::uint32_t index) { return BoxChild(index); }
    [[nodiscard]] static constexpr BoxChild item(std::uint32_t index) {
        return BoxChild(index | kItem);
    }
    [[nodiscard]] static constexpr BoxChild from_code(std::uint32_t code) { return BoxChild(code); }

    [[nodiscard]] constexpr bool is_item() const { return (code_ & kItem) != 0; }
    [[nodiscard]] constexpr std::uint32_t index() const { return code_ & ~kItem; }
    [[nodiscard]] constexpr std::uint32_t code() const { return code_; }

private:
    static constexpr std::uint32_t kItem = 0x80000000U;
    constexpr explicit BoxChild(std::uint32_t code) : code_(code) {}

    std::uint32_t code_;
};

/// Boxes in a node.
inline constexpr std::size_t kBoxLanes = 8;

/// One value for each box of a node.
using BoxLanes = std::array<Float4, kBoxLanes / 4>;

[[nodiscard]] inline float lane_value(const BoxLanes &values, std::size_t lane) noexcept {
    return values[lane / 4][lane % 4];
}

/// Four cache lines. Unused lanes have an inverted box, which nothing enters.
struct alignas(64) BoxNode {
    /// Lower x, y, z, then upper x, y, z; one lane for each child. Rounded outwards.
    std::array<BoxLanes, 6> walls_m;
    std::array<BoxChild, kBoxLanes> children;

    /// Which children are items, as bits.
    [[nodiscard]] unsigned items() const noexcept {
        const auto codes = std::bit_cast<std::array<Mask4, kBoxLanes / 4>>(children);
        return lane_bits(codes[0]) | lane_bits(codes[1]) << 4U;
    }

    [[nodiscard]] static BoxNode empty() noexcept {
        constexpr float kInfinity = std::numeric_limits<float>::infinity();
        const BoxLanes above{all_lanes(kInfinity), all_lanes(kInfinity)};
        const BoxLanes below{all_lanes(-kInfinity), all_lanes(-kInfinity)};
        constexpr BoxChild kNone = BoxChild::item(0);
        return {{above, above, above, below, below, below},
                {kNone, kNone, kNone, kNone, kNone, kNone, kNone, kNone}};
    }
};

/// Maximum depth of a node below the root.
inline constexpr int kDeepestBoxNode = 56;

} // namespace springdrive::contact
