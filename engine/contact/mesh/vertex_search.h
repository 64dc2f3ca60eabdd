// Finds vertices: near a line segment, however uneven their distribution, and near a point.
#pragma once

#include "base/assertions.h"
#include "base/vector.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace springdrive::contact {

/// Finds points near a line segment: a k-d tree (Bentley 1975) kept in the order of its points,
/// medians in the middle.
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

/// Finds vertices near a point: a hash table from the cells of a grid to the vertices in them.
/// However many vertices share a cell, inserting one costs the same. It stores tags, parts of the
/// cells' hashes, instead of cells: two cells may share a tag, so the distance decides.
class VertexGrid {
public:
    /// Has room for `vertices_m`, which must outlive it, and none of them yet.
    /// @pre cell_m of at least twice reach_m: points within reach are in at most eight cells
    VertexGrid(const std::vector<Vector3> &vertices_m, double reach_m, double cell_m,
               unsigned threads = 1);

    /// An insertion or a search a few vertices later finds its place in the cache.
    void prefetch(std::uint32_t vertex) const {
        __builtin_prefetch(&slots_[homes_[vertex].address.slot]);
    }

    /// @pre the vertex is not in it yet
    void insert(std::uint32_t vertex) {
        const Address &address = homes_[vertex].address;
        Slot &slot = slots_[address.slot];
        SPRINGDRIVE_ASSERT_AUDIT(std::ranges::none_of(
            entries_of(slot), [vertex](const Entry &entry) { return entry.vertex == vertex; }));
        entries_[slot.first + slot.count++] = {address.tag, vertex};
    }

    /// Inserts all vertices, in ascending order.
    /// @pre it is empty
    void insert_all(unsigned threads);

    /// Calls `visit(other)` for inserted vertices of a lower number within reach of a vertex until
    /// it returns true: first those in its own cell, in each cell in the order of insertion. May
    /// visit a vertex twice. Returns how many were compared.
    /// @pre vertices were inserted in ascending order
    template <typename Visit>
    [[nodiscard]] std::uint64_t visit_earlier(std::uint32_t vertex, const Visit &visit) const {
        std::uint64_t compared = 0;
        const Home &home = homes_[vertex];
        if (visit_cell(home.address, vertex, visit, compared) || !home.is_near_wall) {
            return compared;
        }
        Addresses addresses;
        const std::size_t count = cells_around(vertex, addresses);
        for (std::size_t i = 0; i < count; ++i) {
            if (visit_cell(addresses[i], vertex, visit, compared)) {
                break;
            }
        }
        return compared;
    }

    /// A slot prefetched this many vertices ahead arrives in time.
    static constexpr std::uint32_t kAhead = 16;

private:
    /// Where to look for the vertices of a cell.
    struct Address {
        std::uint32_t slot = 0;
        std::uint32_t tag = 0;
    };

    /// The cell that a vertex is in.
    struct Home {
        Address address;
        bool is_near_wall = false; ///< points within reach of the vertex may be in other cells
    };

    /// A range of entries with room for all vertices whose homes are here.
    struct Slot {
        std::uint32_t first = 0;
        std::uint32_t count = 0; ///< inserted
    };

    struct Entry {
        std::uint32_t tag = 0;
        std::uint32_t vertex = 0;
    };

    using Addresses = std::array<Address, 8>;

    /// Calls `visit(vertex)` for all vertices, those of one slot in ascending order and in the same
    /// thread.
    template <typename Visit> void for_each_of_slots(unsigned threads, const Visit &visit);

    [[nodiscard]] Home home_of(std::uint32_t vertex) const;

    /// The cells within reach of a vertex except its own, and their number.
    [[nodiscard]] std::size_t cells_around(std::uint32_t vertex, Addresses &addresses) const;

    [[nodiscard]] Vector3 cell_of(const Vector3 &point_m) const;
    [[nodiscard]] Address address_of(const Vector3 &cell) const;

    [[nodiscard]] std::span<const Entry> entries_of(const Slot &slot) const {
        return std::span(entries_).subspan(slot.first, slot.count);
    }

    template <typename Visit>
    [[nodiscard]] bool visit_cell(const Address &address, std::uint32_t vertex, const Visit &visit,
                                  std::uint64_t &compared) const {
        for (const Entry &entry : entries_of(slots_[address.slot])) {
            if (entry.vertex >= vertex) {
                break;
            }
            ++compared;
            if (entry.tag == address.tag && is_near(entry.vertex, vertex) && visit(entry.vertex)) {
                return true;
            }
        }
        return false;
    }

    [[nodiscard]] bool is_near(std::uint32_t a, std::uint32_t b) const {
        return (vertices_m_[a] - vertices_m_[b]).squaredNorm() <= reach_m_ * reach_m_;
    }

    const std::vector<Vector3> &vertices_m_;
    double reach_m_;
    double cells_per_m_;
    std::vector<Slot> slots_; ///< at least as many as vertices, and a power of two
    std::size_t last_slot_;
    std::vector<Home> homes_; ///< of the vertices
    std::vector<Entry> entries_;
};

} // namespace springdrive::contact
