#include "engine/contact/mesh/point_tree.h"

#include "base/cancellation.h"
#include "base/parallel.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace springdrive::contact {

namespace {

/// Threads take time to start.
constexpr std::size_t kMinShared = 20'000;

} // namespace

PointTree::PointTree(const std::vector<Vector3> &points_m, unsigned threads) {
    nodes_.reserve(points_m.size());
    for (const Vector3 &point_m : points_m) {
        nodes_.push_back({point_m, static_cast<std::uint32_t>(nodes_.size())});
    }
    build(0, nodes_.size(), threads);
}

void PointTree::build(std::size_t first, std::size_t last, unsigned threads) {
    if (last - first < 2) {
        return;
    }
    stop_if_given_up(first);
    Eigen::AlignedBox3d box;
    for (std::size_t i = first; i < last; ++i) {
        box.extend(nodes_[i].place_m);
    }
    Eigen::Index axis = 0;
    box.sizes().maxCoeff(&axis);
    const std::size_t middle = first + (last - first) / 2;
    const auto at = [this](std::size_t i) {
        return nodes_.begin() + static_cast<std::ptrdiff_t>(i);
    };
    std::nth_element(at(first), at(middle), at(last), [axis](const Node &a, const Node &b) {
        return a.place_m[axis] < b.place_m[axis];
    });
    nodes_[middle].axis = static_cast<std::uint32_t>(axis);
    // The halves may differ in work, so there are more parts than threads.
    const bool is_shared = threads > 1 && last - first >= kMinShared;
    const unsigned of_each = is_shared ? (threads + 1) / 2 : 1;
    for_each_in_parallel(2, is_shared ? 2 : 1, [&](std::size_t half) {
        half == 0 ? build(first, middle, of_each) : build(middle + 1, last, of_each);
    });
}

std::pair<PointTree::Range, PointTree::Range> PointTree::halves(const Range &range,
                                                                const Segment &segment) const {
    const std::size_t middle = middle_of(range);
    Range lower{range.first, middle, range.start, range.end};
    Range upper{middle + 1, range.last, range.start, range.end};
    // A foot is within reach of its point. Twice that leaves room for round-off.
    const auto axis = static_cast<Eigen::Index>(nodes_[middle].axis);
    const double way = segment.way_m[axis];
    const double inverse_way = segment.inverse_way_per_m[axis];
    const double to_wall = nodes_[middle].place_m[axis] - segment.from_m[axis];
    const double reach = 2.0 * segment.reach_m;
    if (way > 0.0) {
        lower.end = std::min(lower.end, (to_wall + reach) * inverse_way);
        upper.start = std::max(upper.start, (to_wall - reach) * inverse_way);
    } else if (way < 0.0) {
        lower.start = std::max(lower.start, (to_wall + reach) * inverse_way);
        upper.end = std::min(upper.end, (to_wall - reach) * inverse_way);
    } else {
        lower.last = to_wall + reach < 0.0 ? lower.first : lower.last;
        upper.first = to_wall - reach > 0.0 ? upper.last : upper.first;
    }
    return {lower, upper};
}

} // namespace springdrive::contact
