#include "engine/contact/mesh/mesh_topology.h"

#include "base/assertions.h"
#include "base/cancellation.h"
#include "base/parallel.h"

#include <Eigen/Geometry>

#include <numeric>

namespace springdrive::contact {

namespace {

/// Calls `visit(lower, upper, side, is_forward)` for the three sides of a triangle.
template <typename Visit> void for_each_side(const VertexTriple &vertices, Visit visit) {
    for (std::uint32_t side = 0; side < 3; ++side) {
        const std::uint32_t from = vertices[side];
        const std::uint32_t to = vertices[side == 2 ? 0 : side + 1];
        visit(std::min(from, to), std::max(from, to), side, from < to);
    }
}

} // namespace

EdgeTable::EdgeTable(const std::vector<MeshTriangle> &triangles, std::size_t vertices,
                     unsigned threads)
    : first_use_(vertices + 1), uses_(3 * triangles.size()) {
    SPRINGDRIVE_ASSERT(triangles.size() <= kMaxTriangles);
    SPRINGDRIVE_ASSERT_AUDIT(std::ranges::all_of(triangles, [&](const MeshTriangle &triangle) {
        const auto &[a, b, c] = triangle.vertices;
        return std::max({a, b, c}) < vertices && a != b && b != c && c != a;
    }));
    // A counting sort by the lower vertex: each thread counts its share of the triangles, which
    // gives the places of its uses.
    std::vector<std::vector<std::uint32_t>> next_of_chunk(threads);
    in_chunks(triangles.size(), threads, [&](unsigned chunk, std::size_t first, std::size_t last) {
        std::vector<std::uint32_t> &counts = next_of_chunk[chunk];
        counts.assign(vertices, 0);
        for (std::size_t i = first; i < last; ++i) {
            stop_if_given_up(i);
            for_each_side(triangles[i].vertices,
                          [&](std::uint32_t lower, auto...) { ++counts[lower]; });
        }
    });
    std::uint32_t total = 0;
    for (std::size_t vertex = 0; vertex < vertices; ++vertex) {
        stop_if_given_up(vertex);
        first_use_[vertex] = total;
        for (std::vector<std::uint32_t> &next : next_of_chunk) {
            const std::uint32_t count = next[vertex];
            next[vertex] = total;
            total += count;
        }
    }
    first_use_[vertices] = total;
    in_chunks(triangles.size(), threads, [&](unsigned chunk, std::size_t first, std::size_t last) {
        std::vector<std::uint32_t> &next = next_of_chunk[chunk];
        for (std::size_t i = first; i < last; ++i) {
            stop_if_given_up(i);
            for_each_side(triangles[i].vertices, [&](std::uint32_t lower, std::uint32_t upper,
                                                     std::uint32_t side, bool is_forward) {
                uses_[next[lower]++] =
                    EdgeUse(upper, static_cast<std::uint32_t>(i), side, is_forward);
            });
        }
    });
    in_chunks(vertices, threads, [&](unsigned, std::size_t first, std::size_t last) {
        for (std::size_t vertex = first; vertex < last; ++vertex) {
            stop_if_given_up(vertex);
            std::sort(uses_.data() + first_use_[vertex], uses_.data() + first_use_[vertex + 1]);
        }
    });
}

std::span<const EdgeUse> EdgeTable::uses_of(std::uint32_t a, std::uint32_t b) const {
    const std::uint32_t lower = std::min(a, b);
    const std::uint32_t upper = std::max(a, b);
    const EdgeUse *const end = uses_.data() + first_use_[lower + 1];
    const auto upper_of = [](const EdgeUse &use) { return use.upper(); };
    const EdgeUse *const first =
        std::ranges::lower_bound(uses_.data() + first_use_[lower], end, upper, {}, upper_of);
    return {first, std::ranges::upper_bound(first, end, upper, {}, upper_of)};
}

std::size_t count_open(const EdgeTable &edges) {
    std::size_t open = 0;
    edges.for_each([&](const Edge &edge) { open += edge.is_open() ? 1 : 0; });
    return open;
}

BoundaryVertices::BoundaryVertices(const std::vector<MeshTriangle> &triangles,
                                   const EdgeTable &edges, const std::vector<Vector3> &vertices_m)
    : numbers_(vertices_m.size(), kNone) {
    edges.for_each([&](const Edge &edge) {
        if (edge.is_open()) {
            numbers_[edge.lower] = 0;
            numbers_[edge.upper()] = 0;
        }
    });
    for (std::uint32_t vertex = 0; vertex < numbers_.size(); ++vertex) {
        if (has(vertex)) {
            numbers_[vertex] = static_cast<std::uint32_t>(vertices_.size());
            vertices_.push_back(vertex);
            places_m_.push_back(vertices_m[vertex]);
        }
    }

    const auto for_each_corner = [&](auto visit) {
        for (std::uint32_t i = 0; i < triangles.size(); ++i) {
            for (const std::uint32_t corner : triangles[i].vertices) {
                if (has(corner)) {
                    visit(numbers_[corner], i);
                }
            }
        }
    };
    // A counting sort: filling a range moves its end down to its start.
    first_at_.assign(size() + 1, 0);
    for_each_corner([&](std::uint32_t number, std::uint32_t) { ++first_at_[number]; });
    std::partial_sum(first_at_.begin(), first_at_.end(), first_at_.begin());
    triangles_at_.resize(first_at_.back());
    for_each_corner([&](std::uint32_t number, std::uint32_t triangle) {
        triangles_at_[--first_at_[number]] = triangle;
    });
}

namespace {

/// How often an edge is traversed: forwards minus backwards.
struct EdgeBalance {
    int all = 0;
    int of_one_winding = 0; ///< of the triangles of one winding only
};

[[nodiscard]] EdgeBalance balance_of(const Edge &edge, const std::vector<MeshTriangle> &triangles) {
    EdgeBalance balance;
    for (const EdgeUse &use : edge.uses) {
        const int direction = use.is_forward() ? 1 : -1;
        balance.all += direction;
        balance.of_one_winding += triangles[use.triangle()].has_both_windings ? 0 : direction;
    }
    return balance;
}

/// Numbers the sets by their first triangles. Returns how many there are.
std::uint32_t number_components(TriangleSets &sets, std::vector<std::uint32_t> &component) {
    std::uint32_t count = 0;
    for (std::uint32_t triangle = 0; triangle < component.size(); ++triangle) {
        const std::uint32_t root = sets.root_of(triangle);
        component[triangle] = root == triangle ? count++ : component[root];
    }
    return count;
}

} // namespace

MeshTopology find_topology(const std::vector<MeshTriangle> &triangles, const EdgeTable &edges) {
    MeshTopology topology;
    TriangleSets sets(triangles.size());
    edges.for_each([&](const Edge &edge) {
        topology.open_edges += edge.is_open() ? 1 : 0;
        topology.non_manifold_edges += edge.uses.size() > 2 ? 1 : 0;
        for (const EdgeUse &use : edge.uses.subspan(1)) {
            sets.unite(edge.uses.front().triangle(), use.triangle(), false);
        }
    });
    topology.component_of_triangle.resize(triangles.size());
    const std::uint32_t count = number_components(sets, topology.component_of_triangle);

    std::vector<bool> is_shut_by_all(count, true);
    std::vector<bool> is_shut_by_one_winding(count, false);
    bool has_both_windings = false;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        has_both_windings = has_both_windings || triangles[i].has_both_windings;
        if (!triangles[i].has_both_windings) {
            is_shut_by_one_winding[topology.component_of_triangle[i]] = true;
        }
    }
    topology.components.resize(count);
    edges.for_each([&](const Edge &edge) {
        const bool is_turned = edge.is_run_twice_the_same_way();
        if (edge.is_manifold() && !is_turned && !has_both_windings) {
            return; // nearly all edges of nearly all meshes
        }
        const EdgeBalance balance = balance_of(edge, triangles);
        const std::uint32_t number = topology.component_of_triangle[edge.uses.front().triangle()];
        if (balance.all != 0) {
            is_shut_by_all[number] = false;
        }
        if (balance.of_one_winding != 0) {
            is_shut_by_one_winding[number] = false;
        }
        if (is_turned) {
            topology.components[number].is_orientable = false;
        }
    });
    for (std::size_t i = 0; i < count; ++i) {
        topology.components[i].is_closed = is_shut_by_all[i] || is_shut_by_one_winding[i];
        topology.components[i].has_sheets_apart = is_shut_by_one_winding[i];
    }
    return topology;
}

std::vector<double> enclosed_volumes_m3(const std::vector<MeshTriangle> &triangles,
                                        const MeshTopology &topology,
                                        const std::vector<Vector3> &vertices_m) {
    std::vector<double> volumes(topology.components.size(), 0.0);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const std::uint32_t number = topology.component_of_triangle[i];
        const MeshComponent &component = topology.components[number];
        if (!component.is_closed ||
            (component.has_sheets_apart && triangles[i].has_both_windings)) {
            continue;
        }
        // From the tetrahedra to a point near the mesh.
        const Vector3 &origin = vertices_m[triangles.front().vertices[0]];
        const auto &[a, b, c] = triangles[i].vertices;
        volumes[number] +=
            (vertices_m[a] - origin).dot((vertices_m[b] - origin).cross(vertices_m[c] - origin)) /
            6.0;
    }
    return volumes;
}

} // namespace springdrive::contact
