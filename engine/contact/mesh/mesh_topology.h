// The edges of a mesh, which triangles are connected over them, and which volumes they enclose.
#pragma once

#include "base/assertions.h"
#include "base/cancellation.h"
#include "base/vector.h"
#include "engine/contact/mesh/triangle_soup.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace springdrive::contact {

/// One side of one triangle. Orders by the edge's upper vertex, then by triangle.
class EdgeUse {
public:
    EdgeUse() = default;
    EdgeUse(std::uint32_t upper, std::uint32_t triangle, std::uint32_t side, bool is_forward)
        : packed_(std::uint64_t{upper} << 32 | std::uint64_t{triangle} << 3 |
                  std::uint64_t{side} << 1 | std::uint64_t{is_forward}) {}

    [[nodiscard]] std::uint32_t upper() const { return static_cast<std::uint32_t>(packed_ >> 32); }
    [[nodiscard]] std::uint32_t triangle() const {
        return static_cast<std::uint32_t>(packed_) >> 3;
    }
    /// Which corner of the triangle it starts from: 0, 1 or 2.
    [[nodiscard]] std::uint32_t side() const {
        return static_cast<std::uint32_t>(packed_) >> 1 & 3U;
    }
    /// Whether the triangle runs along it from the lower vertex to the upper.
    [[nodiscard]] bool is_forward() const { return (packed_ & 1U) != 0; }

    friend bool operator<(const EdgeUse &a, const EdgeUse &b) { return a.packed_ < b.packed_; }

private:
    std::uint64_t packed_ = 0;
};

/// The uses of one edge, at least one.
struct Edge {
    std::uint32_t lower = 0; ///< vertex
    std::span<const EdgeUse> uses;

    [[nodiscard]] std::uint32_t upper() const { return uses.front().upper(); }
    [[nodiscard]] bool is_open() const { return uses.size() == 1; }
    [[nodiscard]] bool is_manifold() const { return uses.size() == 2; }

    /// Manifold, but its two triangles disagree about which side is out.
    [[nodiscard]] bool is_run_twice_the_same_way() const {
        return is_manifold() && uses[0].is_forward() == uses[1].is_forward();
    }
};

/// All edges of a mesh, ordered by their lower, then by their upper vertex.
class EdgeTable {
public:
    /// @pre at most kMaxTriangles, of vertices below `vertices`, each of three different ones
    EdgeTable(const std::vector<MeshTriangle> &triangles, std::size_t vertices, unsigned threads);

    [[nodiscard]] std::size_t vertices() const { return first_use_.size() - 1; }

    /// The uses of the edge between two vertices; empty if there is no such edge.
    [[nodiscard]] std::span<const EdgeUse> uses_of(std::uint32_t a, std::uint32_t b) const;

    /// A number below `uses()` that no other edge has.
    /// @pre there is such an edge
    [[nodiscard]] std::size_t first_use_of(std::uint32_t a, std::uint32_t b) const {
        return static_cast<std::size_t>(uses_of(a, b).data() - uses_.data());
    }
    [[nodiscard]] std::size_t uses() const { return uses_.size(); }

    /// Calls `visit(edge)` for every edge whose lower vertex is in the range.
    template <typename Visit>
    void for_each(std::size_t first_vertex, std::size_t last_vertex, Visit visit) const {
        for (std::size_t vertex = first_vertex; vertex < last_vertex; ++vertex) {
            stop_if_given_up(vertex);
            const EdgeUse *use = uses_.data() + first_use_[vertex];
            const EdgeUse *const end = uses_.data() + first_use_[vertex + 1];
            while (use != end) {
                const EdgeUse *last = use + 1;
                while (last != end && last->upper() == use->upper()) {
                    ++last;
                }
                visit(Edge{static_cast<std::uint32_t>(vertex), {use, last}});
                use = last;
            }
        }
    }

    template <typename Visit> void for_each(Visit visit) const { for_each(0, vertices(), visit); }

private:
    std::vector<std::uint32_t> first_use_; ///< of each lower vertex, and the end
    std::vector<EdgeUse> uses_;
};

[[nodiscard]] std::size_t count_open(const EdgeTable &edges);

/// Numbers the ends of open edges from zero, in the order of the vertices.
class BoundaryVertices {
public:
    /// @param edges those of `triangles`
    BoundaryVertices(const std::vector<MeshTriangle> &triangles, const EdgeTable &edges,
                     const std::vector<Vector3> &vertices_m);

    [[nodiscard]] std::size_t size() const { return vertices_.size(); }
    [[nodiscard]] std::uint32_t vertex(std::uint32_t number) const { return vertices_[number]; }
    [[nodiscard]] const std::vector<Vector3> &places_m() const { return places_m_; }
    [[nodiscard]] const Vector3 &place_m(std::uint32_t number) const { return places_m_[number]; }

    [[nodiscard]] bool has(std::uint32_t vertex) const { return numbers_[vertex] != kNone; }
    [[nodiscard]] std::uint32_t number_of(std::uint32_t vertex) const { return numbers_[vertex]; }

    /// All triangles with the vertex as a corner, including those without an open edge.
    [[nodiscard]] std::span<const std::uint32_t> triangles_at(std::uint32_t number) const {
        return std::span(triangles_at_)
            .subspan(first_at_[number], first_at_[number + 1] - first_at_[number]);
    }

private:
    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

    std::vector<std::uint32_t> numbers_; ///< of all vertices
    std::vector<std::uint32_t> vertices_;
    std::vector<Vector3> places_m_;
    std::vector<std::uint32_t> first_at_;
    std::vector<std::uint32_t> triangles_at_;
};

/// Disjoint sets of triangles with the relative winding of their members: union-find with path
/// halving; each link stores whether its two ends are wound oppositely. The root of a set is its
/// first triangle.
class TriangleSets {
public:
    struct Place {
        std::uint32_t root = 0;
        bool is_opposite = false; ///< wound opposite to the root
    };

    /// @pre at most kMaxTriangles
    explicit TriangleSets(std::size_t count) : link_(count) {
        SPRINGDRIVE_ASSERT(count <= kMaxTriangles);
        for (std::uint32_t triangle = 0; triangle < count; ++triangle) {
            link_[triangle] = triangle << 1;
        }
    }

    [[nodiscard]] Place place_of(std::uint32_t triangle) {
        std::uint32_t parity = 0;
        while (link_[triangle] >> 1 != triangle) {
            const std::uint32_t parent = link_[triangle];
            link_[triangle] = link_[parent >> 1] ^ (parent & 1U);
            parity ^= link_[triangle] & 1U;
            triangle = link_[triangle] >> 1;
        }
        return {triangle, parity != 0};
    }

    [[nodiscard]] std::uint32_t root_of(std::uint32_t triangle) { return place_of(triangle).root; }

    /// False if both are already in one set with the other relative winding.
    bool unite(std::uint32_t a, std::uint32_t b, bool are_opposite) {
        const Place at = place_of(a);
        const Place bt = place_of(b);
        const bool is_odd = at.is_opposite != bt.is_opposite;
        if (at.root == bt.root) {
            return is_odd == are_opposite;
        }
        link_[std::max(at.root, bt.root)] =
            std::min(at.root, bt.root) << 1 | std::uint32_t{is_odd != are_opposite};
        return true;
    }

private:
    std::vector<std::uint32_t> link_; ///< parent · 2 + parity
};

/// Triangles connected over edges.
///
/// Closed: every edge is traversed as often forwards as backwards. That holds for closed surfaces
/// of one consistent winding, also where two of them share an edge, as voxels do, and makes
/// "inside" well defined. Triangles of both windings either do not count at all, as sheets within
/// or on a solid, or all count with their own winding.
struct MeshComponent {
    bool is_closed = true;
    bool is_orientable = true; ///< false: triangles cannot be turned to agree on which side is out
    /// Of a closed one, whether triangles of both windings are not part of its closed surface.
    bool has_sheets_apart = true;
};

struct MeshTopology {
    std::vector<std::uint32_t> component_of_triangle;
    std::vector<MeshComponent> components;
    std::size_t open_edges = 0;         ///< used by one triangle only
    std::size_t non_manifold_edges = 0; ///< used by more than two triangles
};

[[nodiscard]] MeshTopology find_topology(const std::vector<MeshTriangle> &triangles,
                                         const EdgeTable &edges);

/// The volume of each closed component [m³], negative where its triangles face it; zero for open
/// ones and for sheets. For a solid with sheets in it, that of the solid alone.
[[nodiscard]] std::vector<double> enclosed_volumes_m3(const std::vector<MeshTriangle> &triangles,
                                                      const MeshTopology &topology,
                                                      const std::vector<Vector3> &vertices_m);

} // namespace springdrive::contact
