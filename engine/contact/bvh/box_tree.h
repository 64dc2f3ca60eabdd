// Finds, among millions of boxes, the few that a motion enters or that lie near a point.
// Independent of what is in the boxes.
//
//   node ┬ box ─► item          Each node holds up to eight boxes, with an item or another node in
//        ├ box ─► item          each. Nodes and items are numbered in the order in which a walk
//        ├ box ─► node ┬ ...    through the whole tree comes to them, so neighbours in space are
//        └ (empty)     └ ...    neighbours in memory.
#pragma once

#include "base/vector.h"
#include "engine/contact/bvh/box_node.h"
#include "engine/contact/bvh/box_search.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace springdrive::contact {

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
