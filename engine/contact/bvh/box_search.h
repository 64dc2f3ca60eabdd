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
#pragma once

#include "base/vector.h"
#include "engine/contact/bvh/box_node.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace springdrive::contact {

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

} // namespace springdrive::contact
