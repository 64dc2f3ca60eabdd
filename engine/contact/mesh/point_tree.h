// Finds points near a line segment, however uneven their distribution.
#pragma once

#include "base/vector.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace springdrive::contact {

/// A k-d tree (Bentley 1975) kept in the order of its points, medians in the middle.
class PointTree {
public:
    explicit PointTree(const std::vector<Vector3> &points_m, unsigned threads = 1);

    /// Calls `visit(point, fraction, distance_m)` for points whose feet lie within the segment,
    /// its ends excluded, no farther than `reach_m` from them, until it returns true. Returns how
    /// many points were compared.
    template <typename Visit>
    [[nodiscard]] std::uint64_t visit_along(const Vector3 &from_m, const Vector3 &to_m,
                                            double reach_m, const Visit &visit) const {
        std::uint64_t compared = 0;
        const Segment segment(from_m, to_m, reach_m);
        visit_range({0, nodes_.size(), 0.0, 1.0}, segment, visit, compared);
        return compared;
    }

private:
    struct Node {
        Vector3 place_m;
        std::uint32_t point = 0;
        std::uint32_t axis = 0; ///< lower points before it, upper ones after it
    };

    struct Segment {
        Segment(const Vector3 &from, const Vector3 &to, double reach)
            : from_m(from), way_m(to - from), inverse_way_per_m(way_m.cwiseInverse()),
              squared_way_m2(way_m.squaredNorm()), reach_m(reach) {}

        Vector3 from_m;
        Vector3 way_m;
        Vector3 inverse_way_per_m;
        double squared_way_m2;
        double reach_m;
    };

    /// Nodes, and the part of the segment on which their feet may lie.
    struct Range {
        std::size_t first = 0;
        std::size_t last = 0;
        double start = 0.0;
        double end = 0.0;
    };

    [[nodiscard]] static std::size_t middle_of(const Range &range) {
        return range.first + (range.last - range.first) / 2;
    }

    void build(std::size_t first, std::size_t last, unsigned threads);

    /// The two halves of a range about its middle node.
    [[nodiscard]] std::pair<Range, Range> halves(const Range &range, const Segment &segment) const;

    template <typename Visit>
    bool visit_range(const Range &range, const Segment &segment, const Visit &visit,
                     std::uint64_t &compared) const {
        if (range.first == range.last || !(range.start <= range.end)) {
            return false;
        }
        ++compared;
        const auto [lower, upper] = halves(range, segment);
        return visit_node(nodes_[middle_of(range)], segment, visit) ||
               visit_range(lower, segment, visit, compared) ||
               visit_range(upper, segment, visit, compared);
    }

    template <typename Visit>
    static bool visit_node(const Node &node, const Segment &segment, const Visit &visit) {
        const Vector3 offset = node.place_m - segment.from_m;
        const double along_m2 = offset.dot(segment.way_m);
        if (!(along_m2 > 0.0)) {
            return false;
        }
        // Most points are clearly too far away, which is seen without a division.
        const double squared_m2 = offset.squaredNorm();
        const double squared_beside_m4 = squared_m2 * segment.squared_way_m2 - along_m2 * along_m2;
        const double clear_m2 = 2.0 * segment.reach_m * segment.reach_m + kRoundOff * squared_m2;
        if (squared_beside_m4 > clear_m2 * segment.squared_way_m2) {
            return false;
        }
        const double fraction = along_m2 / segment.squared_way_m2;
        const double distance_m = (offset - fraction * segment.way_m).norm();
        return fraction > 0.0 && fraction < 1.0 && distance_m <= segment.reach_m &&
               visit(node.point, fraction, distance_m);
    }

    /// Above that of a difference of products.
    static constexpr double kRoundOff = 1e-14;

    std::vector<Node> nodes_;
};

} // namespace springdrive::contact
