// Boxes that a search has met but not yet looked into, nearest on top.
#pragma once

#include "engine/contact/bvh/box_node.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace springdrive::contact {

/// A child and how far off its box is: a number not below zero, in whatever the search measures.
/// Both in one word, ordered by the distance: such floats are in the order of their bits.
class WaitingBox {
public:
    WaitingBox() = default; ///< unset: a search has no time to write a stack that it will not use
    WaitingBox(float distance, BoxChild child) noexcept
        : word_(std::uint64_t{std::bit_cast<std::uint32_t>(distance)} << 32U | child.code()) {}

    [[nodiscard]] float distance() const noexcept {
        return std::bit_cast<float>(static_cast<std::uint32_t>(word_ >> 32U));
    }
    [[nodiscard]] BoxChild child() const noexcept {
        return BoxChild::from_code(static_cast<std::uint32_t>(word_));
    }
    [[nodiscard]] bool is_nearer_than(WaitingBox other) const noexcept {
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

/// A stack that cannot overflow: all but one of the boxes of each node above the current
/// one may wait. Its storage lies apart, so that the compiler keeps the rest in registers.
class WaitingBoxes {
public:
    using Storage = std::array<WaitingBox, (kBoxLanes - 1) * kDeepestBoxNode + kBoxLanes>;

    explicit WaitingBoxes(Storage &storage) noexcept : bottom_(storage.data()), top_(bottom_) {}

    void push(WaitingBox box) noexcept { *top_++ = box; }

    /// Takes boxes off until one is no farther than `limit`. False if there is none.
    [[nodiscard, gnu::always_inline]] bool pop(WaitingBox &box, float limit) noexcept {
        while (top_ != bottom_) {
            box = *--top_;
            if (box.distance() <= limit) {
                return true;
            }
        }
        return false;
    }

    /// The distance of the nearest of all that wait, and of `current`.
    [[nodiscard, gnu::always_inline]] double nearest(WaitingBox current) const noexcept {
        float nearest = current.distance();
        for (const WaitingBox *box = bottom_; box != top_; ++box) {
            nearest = std::min(nearest, box->distance());
        }
        return nearest;
    }

    /// Pushes those children of a node that `hits` names, at least one, but for the nearest, which
    /// it returns.
    [[nodiscard, gnu::always_inline]] WaitingBox
    push_all_but_nearest(const BoxNode &node, const BoxLanes &distances, LaneSet hits) noexcept {
        const auto take = [&] {
            const std::size_t lane = hits.take();
            return WaitingBox(lane_value(distances, lane), node.children[lane]);
        };
        WaitingBox nearest = take();
        const WaitingBox *const first_pushed = top_;
        while (!hits.empty()) {
            WaitingBox box = take();
            if (box.is_nearer_than(nearest)) {
                std::swap(box, nearest);
            }
            WaitingBox *place = top_++;
            for (; place != first_pushed && place[-1].is_nearer_than(box); --place) {
                *place = place[-1];
            }
            *place = box;
        }
        return nearest;
    }

private:
    WaitingBox *bottom_;
    WaitingBox *top_;
};

} // namespace springdrive::contact
