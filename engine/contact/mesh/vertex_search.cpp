#include "engine/contact/mesh/vertex_search.h"

#include "base/assertions.h"
#include "base/cancellation.h"
#include "base/parallel.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

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

VertexGrid::VertexGrid(const std::vector<Vector3> &vertices_m, double reach_m, double cell_m,
                       unsigned threads)
    : vertices_m_(vertices_m), reach_m_(reach_m), cells_per_m_(1.0 / cell_m),
      slots_(std::bit_ceil(vertices_m.size() + 1)), last_slot_(slots_.size() - 1),
      homes_(vertices_m.size()), entries_(vertices_m.size()) {
    SPRINGDRIVE_ASSERT(cell_m >= 2.0 * reach_m);
    in_chunks(homes_.size(), threads, [&](unsigned, std::size_t first, std::size_t last) {
        for (std::size_t vertex = first; vertex < last; ++vertex) {
            stop_if_given_up(vertex);
            homes_[vertex] = home_of(static_cast<std::uint32_t>(vertex));
        }
    });
    for_each_of_slots(threads, [&](std::uint32_t vertex) {
        ++slots_[homes_[vertex].address.slot].first; // for now the size of its room
    });
    std::uint32_t total = 0;
    for (Slot &slot : slots_) {
        total += std::exchange(slot.first, total);
    }
}

void VertexGrid::insert_all(unsigned threads) {
    for_each_of_slots(threads, [&](std::uint32_t vertex) { insert(vertex); });
}

template <typename Visit> void VertexGrid::for_each_of_slots(unsigned threads, const Visit &visit) {
    // Each thread looks at all vertices, which is quick, and visits those in its share of the
    // slots, which are scattered in memory.
    in_chunks(slots_.size(), threads, [&](unsigned, std::size_t first, std::size_t last) {
        const auto count = static_cast<std::uint32_t>(homes_.size());
        for (std::uint32_t vertex = 0; vertex < count; ++vertex) {
            stop_if_given_up(vertex);
            prefetch(std::min(vertex + kAhead, count - 1));
            const std::uint32_t slot = homes_[vertex].address.slot;
            if (slot >= first && slot < last) {
                visit(vertex);
            }
        }
    });
}

VertexGrid::Home VertexGrid::home_of(std::uint32_t vertex) const {
    const Vector3 &point_m = vertices_m_[vertex];
    const Vector3 reach = Vector3::Constant(reach_m_);
    const Vector3 cell = cell_of(point_m);
    const bool is_near_wall = cell_of(point_m - reach) != cell || cell_of(point_m + reach) != cell;
    return {address_of(cell), is_near_wall};
}

std::size_t VertexGrid::cells_around(std::uint32_t vertex, Addresses &addresses) const {
    const Vector3 reach = Vector3::Constant(reach_m_);
    const Vector3 own = cell_of(vertices_m_[vertex]);
    const Vector3 lower = cell_of(vertices_m_[vertex] - reach);
    const Vector3 upper = cell_of(vertices_m_[vertex] + reach);
    // On each axis the reach ends in the own cell on at least one side.
    const Vector3 other = (lower.array() == own.array()).select(upper, lower);
    std::size_t count = 0;
    for (unsigned corner = 1; corner < 8; ++corner) {
        Vector3 cell = own;
        bool is_repeated = false;
        for (unsigned axis = 0; axis < 3; ++axis) {
            if ((corner & (1U << axis)) != 0) {
                cell[axis] = other[axis];
                is_repeated = is_repeated || other[axis] == own[axis];
            }
        }
        if (!is_repeated) {
            addresses[count++] = address_of(cell);
        }
    }
    return count;
}

/// Integers kept as doubles: these cannot overflow.
Vector3 VertexGrid::cell_of(const Vector3 &point_m) const {
    return (cells_per_m_ * point_m).array().floor();
}

VertexGrid::Address VertexGrid::address_of(const Vector3 &cell) const {
    std::uint64_t mixed = 0;
    for (const double coordinate : cell) {
        // Adding zero turns -0 into +0, which is equal and so must have the same hash.
        mixed = (mixed ^ std::bit_cast<std::uint64_t>(coordinate + 0.0)) * 0x9E3779B97F4A7C15U;
        mixed ^= mixed >> 32;
    }
    return {static_cast<std::uint32_t>(mixed & last_slot_),
            static_cast<std::uint32_t>(mixed >> 32)};
}

} // namespace springdrive::contact
