#include "engine/contact/mesh_topology.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <tuple>

namespace springdrive {

namespace {

/// One side of one triangle.
struct EdgeUse {
    std::uint32_t lower = 0; ///< vertex
    std::uint32_t upper = 0; ///< vertex
    std::uint32_t triangle = 0;
    bool is_forward = true; ///< runs from `lower` to `upper`
};

[[nodiscard]] bool is_same_edge(const EdgeUse &a, const EdgeUse &b) {
    return a.lower == b.lower && a.upper == b.upper;
}

/// All sides of all triangles, the uses of one edge next to each other.
[[nodiscard]] std::vector<EdgeUse> sorted_edge_uses(const std::vector<VertexTriple> &triangles) {
    std::vector<EdgeUse> uses;
    uses.reserve(3 * triangles.size());
    for (std::uint32_t triangle = 0; triangle < triangles.size(); ++triangle) {
        for (std::size_t side = 0; side < 3; ++side) {
            const std::uint32_t from = triangles[triangle][side];
            const std::uint32_t to = triangles[triangle][(side + 1) % 3];
            uses.push_back({std::min(from, to), std::max(from, to), triangle, from < to});
        }
    }
    std::ranges::sort(uses, [](const EdgeUse &a, const EdgeUse &b) {
        return std::tie(a.lower, a.upper, a.triangle) < std::tie(b.lower, b.upper, b.triangle);
    });
    return uses;
}

/// Disjoint sets of triangles, by union with path halving.
class TriangleSets {
public:
    explicit TriangleSets(std::size_t count) : parent_(count) {
        std::iota(parent_.begin(), parent_.end(), 0U);
    }

    [[nodiscard]] std::uint32_t root(std::uint32_t triangle) {
        while (parent_[triangle] != triangle) {
            parent_[triangle] = parent_[parent_[triangle]];
            triangle = parent_[triangle];
        }
        return triangle;
    }

    /// The lower root stays, so that a set's root is its first triangle.
    void unite(std::uint32_t a, std::uint32_t b) {
        const std::uint32_t root_a = root(a);
        const std::uint32_t root_b = root(b);
        parent_[std::max(root_a, root_b)] = std::min(root_a, root_b);
    }

private:
    std::vector<std::uint32_t> parent_;
};

/// Calls `visit` with the uses of one edge, for every edge.
template <typename Visit> void for_each_edge(const std::vector<EdgeUse> &uses, Visit visit) {
    for (auto first = uses.begin(); first != uses.end();) {
        const auto last = std::find_if_not(
            first, uses.end(), [first](const EdgeUse &use) { return is_same_edge(use, *first); });
        visit(std::span(first, last));
        first = last;
    }
}

} // namespace

MeshTopology find_topology(const std::vector<VertexTriple> &triangles) {
    const std::vector<EdgeUse> uses = sorted_edge_uses(triangles);
    MeshTopology topology;
    TriangleSets sets(triangles.size());
    for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
        topology.open_edges += edge.size() == 1 ? 1 : 0;
        topology.non_manifold_edges += edge.size() > 2 ? 1 : 0;
        for (const EdgeUse &use : edge) {
            sets.unite(edge.front().triangle, use.triangle);
        }
    });

    topology.component_of_triangle.resize(triangles.size());
    for (std::uint32_t triangle = 0; triangle < triangles.size(); ++triangle) {
        const std::uint32_t root = sets.root(triangle);
        if (root == triangle) {
            topology.component_of_triangle[triangle] =
                static_cast<std::uint32_t>(topology.is_closed.size());
            topology.is_closed.push_back(true);
        } else {
            topology.component_of_triangle[triangle] = topology.component_of_triangle[root];
        }
    }

    for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
        const auto forward = std::ranges::count_if(edge, &EdgeUse::is_forward);
        if (2 * static_cast<std::size_t>(forward) != edge.size()) {
            topology.is_closed[topology.component_of_triangle[edge.front().triangle]] = false;
        }
    });
    return topology;
}

} // namespace springdrive
