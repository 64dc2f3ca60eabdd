// Finds, among millions of boxes, the few that a motion enters or that lie near a point.
// Independent of what is in the boxes.
//
//   node ┬ box ─► item          Each node holds up to eight boxes, with an item or another node in
//        ├ box ─► item          each. Nodes and items are numbered in the order in which a walk
//        ├ box ─► node ┬ ...    through the whole tree comes to them, so neighbours in space are
//        └ (empty)     └ ...    neighbours in memory.
#pragma once

#include "base/vector.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#ifdef __SSE__
#include <xmmintrin.h>
#endif

namespace springdrive::contact {

// The node of a BoxTree: eight boxes side by side, tested four at a time.
//
// Eight rather than four: a search is bound by the latency of loading one node to find the next, so
// fewer and larger steps are faster (10 to 30 % less time, measured) and need less memory.

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

// The parts of a BoxTree search: probes, which are tested against the boxes of a node, and the
// stack of boxes that were hit but not yet visited.
//
// A probe is a motion or a ball, in floats, arranged so that round-off never loses a box that the
// exact motion or ball would hit.
//
// Why that holds: walls are exact floats. Each difference "wall minus centre of the search" starts
// from a centre moved outwards in double by more than its conversion to float can round, so that
// the exact difference errs on the safe side. What follows is products, differences and sums of
// terms of one sign, each with a relative error of up to 2^-24; kSlack exceeds the sum of these
// errors and is applied in the safe direction.

/// Eight roundings of a float, of which a test makes at most six.
inline constexpr float kSlack = 0x1p-21F;

/// Lengths below this count as zero [m]: far below any size, far above where floats lose digits.
inline constexpr float kNothing_m = 1e-30F;

/// How far to move `centre_m ± reach_m` outwards before its conversion to float [m].
[[nodiscard]] inline double conversion_margin_m(double centre_m, double reach_m) noexcept {
    return 0x1p-23 * (std::abs(centre_m) + reach_m) + 2.0 * kNothing_m;
}

/// A straight motion of something round, along one axis.
class AxisMotion {
public:
    AxisMotion(std::size_t axis, double from_m, double to_m, double reach_m) noexcept {
        const auto length_m = static_cast<float>(to_m - from_m);
        // A motion this short lies in a box as a whole or not at all, and so does the one that
        // replaces it; but the inverse of that is finite: no zero times infinity.
        const float rate_per_m = 1.0F / (std::abs(length_m) < kNothing_m ? kNothing_m : length_m);
        near_rate_per_m_ = all_lanes(rate_per_m * (1.0F - kSlack));
        far_rate_per_m_ = all_lanes(rate_per_m * (1.0F + kSlack));
        // Without a branch, which would be mispredicted: motions go either way.
        const std::size_t falls = std::bit_cast<std::uint32_t>(rate_per_m) >> 31U;
        near_wall_ = axis + 3 * falls;
        far_wall_ = axis + 3 - 3 * falls;
        const double outwards_m =
            std::copysign(reach_m + conversion_margin_m(from_m, reach_m), double{rate_per_m});
        near_from_m_ = all_lanes(static_cast<float>(from_m + outwards_m));
        far_from_m_ = all_lanes(static_cast<float>(from_m - outwards_m));
    }

    /// The fractions of the motion at which it enters four boxes, and at which it leaves them.
    [[nodiscard]] Float4 enters(const BoxNode &node, std::size_t four) const noexcept {
        return (node.walls_m[near_wall_][four] - near_from_m_) * near_rate_per_m_;
    }
    [[nodiscard]] Float4 leaves(const BoxNode &node, std::size_t four) const noexcept {
        return (node.walls_m[far_wall_][four] - far_from_m_) * far_rate_per_m_;
    }

private:
    std::size_t near_wall_; ///< of BoxNode::walls_m: the one reached first
    std::size_t far_wall_;
    Float4 near_from_m_;
    Float4 far_from_m_;
    Float4 near_rate_per_m_;
    Float4 far_rate_per_m_;
};

/// A straight motion of something round.
class MotionProbe {
public:
    MotionProbe(const Vector3 &from_m, const Vector3 &to_m, double reach_m) noexcept
        : x_(0, from_m.x(), to_m.x(), reach_m), y_(1, from_m.y(), to_m.y(), reach_m),
          z_(2, from_m.z(), to_m.z(), reach_m) {}

    /// Which boxes the motion enters no later than `last_fraction`, as bits; `entries` are the
    /// fractions at which it does, never later than the exact ones.
    [[nodiscard]] unsigned enters(const BoxNode &node, float last_fraction,
                                  BoxLanes &entries) const noexcept {
        const auto test = [&](std::size_t four) {
            entries[four] = larger(larger(x_.enters(node, four), y_.enters(node, four)),
                                   larger(z_.enters(node, four), all_lanes(0.0F)));
            const Float4 leave = smaller(smaller(x_.leaves(node, four), y_.leaves(node, four)),
                                         smaller(all_lanes(last_fraction), z_.leaves(node, four)));
            return lane_bits(entries[four] <= leave);
        };
        const unsigned hits = test(0) | test(1) << 4U;
        return hits;
    }

private:
    AxisMotion x_;
    AxisMotion y_;
    AxisMotion z_;
};

/// All that is near a point, along one axis.
class AxisBall {
public:
    explicit AxisBall(double centre_m) noexcept
        : above_m_(all_lanes(static_cast<float>(centre_m + conversion_margin_m(centre_m, 0.0)))),
          below_m_(all_lanes(static_cast<float>(centre_m - conversion_margin_m(centre_m, 0.0)))) {}

    /// How far the centre is beyond the lower and the upper walls of four boxes, squared [m²].
    [[nodiscard]] Float4 squared_distances(Float4 lower_m, Float4 upper_m) const noexcept {
        const Float4 outside_m =
            larger(larger(lower_m - above_m_, below_m_ - upper_m), all_lanes(0.0F));
        return outside_m * outside_m;
    }

private:
    Float4 above_m_;
    Float4 below_m_;
};

class BallProbe {
public:
    explicit BallProbe(const Vector3 &centre_m) noexcept
        : x_(centre_m.x()), y_(centre_m.y()), z_(centre_m.z()) {}

    /// For comparison with squared distances in float [m²]; finite, as the distance to an empty
    /// lane is not.
    [[nodiscard]] static float limit(double squared_radius_m2) noexcept {
        constexpr double kTraceMore = 1.0 + double{kSlack};
        return static_cast<float>(std::min(squared_radius_m2 * kTraceMore + 1e-37, 1e38));
    }

    /// A lower bound of the exact squared distance, equal to it but for round-off [m²].
    [[nodiscard]] static double at_least_m2(float squared_distance_m2) noexcept {
        return double{squared_distance_m2} * (1.0 - double{kSlack});
    }

    /// Which boxes are no farther than `limit`, as bits, and how far they are [m²], but for
    /// round-off.
    [[nodiscard]] unsigned reaches(const BoxNode &node, float limit,
                                   BoxLanes &squared_distances) const noexcept {
        const auto test = [&](std::size_t four) {
            squared_distances[four] =
                x_.squared_distances(node.walls_m[0][four], node.walls_m[3][four]) +
                y_.squared_distances(node.walls_m[1][four], node.walls_m[4][four]) +
                z_.squared_distances(node.walls_m[2][four], node.walls_m[5][four]);
            return lane_bits(squared_distances[four] <= all_lanes(limit));
        };
        const unsigned hits = test(0) | test(1) << 4U;
        return hits;
    }

private:
    AxisBall x_;
    AxisBall y_;
    AxisBall z_;
};

/// A child and the distance of its box: not negative, in the unit of the search. Both in one word,
/// ordered by the distance: floats that are not negative sort as their bits do.
class PendingBox {
public:
    PendingBox() = default; ///< unset: initialising a stack that is hardly used would cost time
    PendingBox(float distance, BoxChild child) noexcept
        : word_(std::uint64_t{std::bit_cast<std::uint32_t>(distance)} << 32U | child.code()) {}

    [[nodiscard]] float distance() const noexcept {
        return std::bit_cast<float>(static_cast<std::uint32_t>(word_ >> 32U));
    }
    [[nodiscard]] BoxChild child() const noexcept {
        return BoxChild::from_code(static_cast<std::uint32_t>(word_));
    }
    [[nodiscard]] bool is_nearer_than(PendingBox other) const noexcept {
        return word_ < other.word_;
    }

private:
    std::uint64_t word_;
};

/// Lanes of a node, taken one after the other.
class LaneSet {
public:
    explicit LaneSet(unsigned bits) noexcept : bits_(bits) {}
    [[nodiscard]] bool empty() const noexcept { return bits_ == 0; }
    [[nodiscard]] std::size_t take() noexcept {
        const auto lane = static_cast<std::size_t>(std::countr_zero(bits_));
        bits_ &= bits_ - 1;
        return lane;
    }

private:
    unsigned bits_;
};

/// A stack that cannot overflow: it has room for all but one of the boxes of each node above the
/// current one. Its storage is separate, so that the compiler keeps the rest in registers.
class TraversalStack {
public:
    using Storage = std::array<PendingBox, (kBoxLanes - 1) * kDeepestBoxNode + kBoxLanes>;

    explicit TraversalStack(Storage &storage) noexcept : bottom_(storage.data()), top_(bottom_) {}

    void push(PendingBox box) noexcept { *top_++ = box; }

    /// Pops boxes until one is no farther than `limit`. False if there is none.
    [[nodiscard, gnu::always_inline]] bool pop(PendingBox &box, float limit) noexcept {
        while (top_ != bottom_) {
            box = *--top_;
            if (box.distance() <= limit) {
                return true;
            }
        }
        return false;
    }

    /// The smallest distance of all boxes on the stack and of `current`.
    [[nodiscard, gnu::always_inline]] double nearest(PendingBox current) const noexcept {
        float nearest = current.distance();
        for (const PendingBox *box = bottom_; box != top_; ++box) {
            nearest = std::min(nearest, box->distance());
        }
        return nearest;
    }

    /// Pushes the children of a node that `hits` selects, at least one, except the nearest, which
    /// it returns.
    [[nodiscard, gnu::always_inline]] PendingBox
    push_all_but_nearest(const BoxNode &node, const BoxLanes &distances, LaneSet hits) noexcept {
        const auto take = [&] {
            const std::size_t lane = hits.take();
            return PendingBox(lane_value(distances, lane), node.children[lane]);
        };
        PendingBox nearest = take();
        const PendingBox *const first_pushed = top_;
        while (!hits.empty()) {
            PendingBox box = take();
            if (box.is_nearer_than(nearest)) {
                std::swap(box, nearest);
            }
            PendingBox *place = top_++;
            for (; place != first_pushed && place[-1].is_nearer_than(box); --place) {
                *place = place[-1];
            }
            *place = box;
        }
        return nearest;
    }

private:
    PendingBox *bottom_;
    PendingBox *top_;
};

/// How much effort a search may still take, in units of about 10 ns: this bounds its time by
/// construction. What visits items takes its own effort from it.
struct SearchBudget {
    int effort_left = 0;
};

/// Of visiting a node, with the cache misses that usually come with it.
inline constexpr int kNodeEffort = 4;

struct BoxTreeLayout {
    std::vector<BoxNode> nodes;       ///< the root first; none if there are no boxes
    std::vector<std::uint32_t> order; ///< item i is boxes[order[i]]
};

/// Built once, then only read, from any thread.
class BoxTree {
public:
    BoxTree() = default;

    /// Builds in `threads` threads, at least one: the same tree for any number of them. In
    /// box_tree_build.cpp: a search does not need it.
    /// @pre boxes are finite and not empty [m]; fewer than 2^30
    explicit BoxTree(std::span<const Eigen::AlignedBox3d> boxes, unsigned threads);

    /// Items are numbered in the order of the tree: item i is boxes[order()[i]].
    [[nodiscard]] const std::vector<std::uint32_t> &order() const noexcept { return layout_.order; }

    /// Moves `order()` out: nothing here needs it.
    [[nodiscard]] std::vector<std::uint32_t> take_order() noexcept {
        return std::move(layout_.order);
    }

    /// Memory that the tree holds [bytes].
    [[nodiscard]] std::size_t bytes() const noexcept {
        return sizeof *this + layout_.nodes.capacity() * sizeof(BoxNode) +
               layout_.order.capacity() * sizeof(std::uint32_t);
    }

    /// Visits the items whose boxes, grown by `reach_m` on all sides, the motion enters, mostly in
    /// the order in which it enters them. Round-off may add a visit, but never loses one. RT-safe.
    ///
    /// @param visit  (std::uint32_t item, double last_fraction) -> double: the fraction of the
    ///               motion that is still of interest, no more than `last_fraction`
    /// @return the fraction up to which the motion was searched: 1 or what `visit` left; if the
    ///         budget ran out, no more than where the first node not searched begins
    template <typename Visit>
    double along(const Vector3 &from_m, const Vector3 &to_m, double reach_m, SearchBudget &budget,
                 Visit &&visit) const noexcept;

    /// Visits the items whose boxes come within `radius_m` of `centre_m`, in unspecified order.
    /// Round-off may add a visit, but never loses one. RT-safe.
    ///
    /// @param visit  (std::uint32_t item, double squared_distance_m2) -> double: the squared radius
    ///               that is still of interest [m²], no more than before. The distance is that to
    ///               the box, rounded down.
    /// @return whether the search is complete: false if the budget ran out
    template <typename Visit>
    bool within(const Vector3 &centre_m, double radius_m, SearchBudget &budget,
                Visit &&visit) const noexcept;

private:
    BoxTreeLayout layout_;
};

template <typename Visit>
double BoxTree::along(const Vector3 &from_m, const Vector3 &to_m, double reach_m,
                      SearchBudget &budget, Visit &&visit) const noexcept {
    if (layout_.nodes.empty()) {
        return 1.0;
    }
    const MotionProbe motion(from_m, to_m, reach_m);
    TraversalStack::Storage storage;
    TraversalStack pending(storage);
    PendingBox next(0.0F, BoxChild::node(0));
    double last_fraction = 1.0;
    // The same as a float, changed only on a branch, so that the node tests do not depend on it.
    float limit = 1.0F;
    do {
        while (!next.child().is_item()) {
            if (budget.effort_left <= 0) {
                return std::min(last_fraction, pending.nearest(next));
            }
            budget.effort_left -= kNodeEffort;
            const BoxNode &node = layout_.nodes[next.child().index()];
            __builtin_prefetch(node.children.data());
            BoxLanes entries;
            const LaneSet hits(motion.enters(node, limit, entries));
            if (hits.empty()) {
                break;
            }
            next = pending.push_all_but_nearest(node, entries, hits);
        }
        if (next.child().is_item()) {
            const double left = visit(next.child().index(), last_fraction);
            if (left < last_fraction) {
                last_fraction = left;
                limit = static_cast<float>(left);
            }
        }
    } while (pending.pop(next, limit));
    return last_fraction;
}

template <typename Visit>
bool BoxTree::within(const Vector3 &centre_m, double radius_m, SearchBudget &budget,
                     Visit &&visit) const noexcept {
    if (layout_.nodes.empty() || !(radius_m >= 0.0)) {
        return true;
    }
    const BallProbe ball(centre_m);
    float limit = BallProbe::limit(radius_m * radius_m);
    TraversalStack::Storage storage;
    TraversalStack pending(storage);
    PendingBox next(0.0F, BoxChild::node(0));
    do {
        if (budget.effort_left <= 0) {
            return false;
        }
        budget.effort_left -= kNodeEffort;
        const BoxNode &node = layout_.nodes[next.child().index()];
        __builtin_prefetch(node.children.data());
        BoxLanes distances;
        const unsigned hits = ball.reaches(node, limit, distances);
        const unsigned items = hits & node.items();
        for (LaneSet lanes(hits ^ items); !lanes.empty();) {
            const std::size_t lane = lanes.take();
            pending.push(PendingBox(lane_value(distances, lane), node.children[lane]));
        }
        for (LaneSet lanes(items); !lanes.empty();) {
            const std::size_t lane = lanes.take();
            const float distance_m2 = lane_value(distances, lane);
            if (distance_m2 <= limit) {
                const double left_m2 =
                    visit(node.children[lane].index(), BallProbe::at_least_m2(distance_m2));
                limit = std::min(limit, BallProbe::limit(left_m2));
            }
        }
    } while (pending.pop(next, limit));
    return true;
}

} // namespace springdrive::contact
