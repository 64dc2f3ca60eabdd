#include "engine/contact/mesh_preparation.h"

#include "engine/contact/mesh_topology.h"
#include "engine/contact/vertex_welding.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cstdint>
#include <stdexcept>

namespace springdrive {

namespace {

/// Vertices closer than this are one [m].
constexpr double kWeldTolerance_m = 1e-7;

/// Triangles lower than this are left out [m]: their normals say little, and the rims of their
/// neighbours cover the gap they leave.
constexpr double kSmallestHeight_m = 1e-8;
static_assert(kSmallestHeight_m < kRim_m);

void require_consistent(const TriangleSoup &soup) {
    const auto is_in_range = [&](const std::array<std::uint32_t, 3> &triangle) {
        return std::ranges::all_of(
            triangle, [&](std::uint32_t vertex) { return vertex < soup.vertices_m.size(); });
    };
    const auto has_material = [&](std::uint16_t material) {
        return material < soup.materials.size();
    };
    if (!std::ranges::all_of(soup.triangles, is_in_range)) {
        throw std::invalid_argument("prepare_mesh: a vertex index is out of range");
    }
    if (soup.material_of_triangle.size() != soup.triangles.size() ||
        !std::ranges::all_of(soup.material_of_triangle, has_material)) {
        throw std::invalid_argument("prepare_mesh: a triangle lacks its material");
    }
}

/// A triangle of welded vertices, and where it came from.
struct WeldedTriangle {
    VertexTriple vertices{};
    std::uint32_t triangle = 0;
};

/// The same triangle in the same winding, lowest vertex first: equal triangles read alike.
[[nodiscard]] VertexTriple lowest_first(VertexTriple vertices) {
    std::rotate(vertices.begin(), std::ranges::min_element(vertices), vertices.end());
    return vertices;
}

[[nodiscard]] bool is_finite(const TriangleSoup &soup, const VertexTriple &vertices) {
    return std::ranges::all_of(
        vertices, [&](std::uint32_t vertex) { return soup.vertices_m[vertex].allFinite(); });
}

/// Triangles of three different finite vertices, welded.
[[nodiscard]] std::vector<WeldedTriangle>
welded_triangles(const TriangleSoup &soup, const std::vector<std::uint32_t> &stands_for) {
    std::vector<WeldedTriangle> welded;
    welded.reserve(soup.triangles.size());
    for (std::uint32_t i = 0; i < soup.triangles.size(); ++i) {
        const auto &[a, b, c] = soup.triangles[i];
        const VertexTriple vertices = lowest_first({stands_for[a], stands_for[b], stands_for[c]});
        const bool is_collapsed =
            vertices[0] == vertices[1] || vertices[1] == vertices[2] || vertices[2] == vertices[0];
        if (!is_collapsed && is_finite(soup, vertices)) {
            welded.push_back({vertices, i});
        }
    }
    return welded;
}

/// Keeps the first of equal triangles. Returns how many were removed.
std::size_t remove_duplicates(std::vector<WeldedTriangle> &triangles) {
    const std::size_t before = triangles.size();
    std::ranges::sort(triangles, [](const WeldedTriangle &a, const WeldedTriangle &b) {
        return a.vertices != b.vertices ? a.vertices < b.vertices : a.triangle < b.triangle;
    });
    const auto is_same = [](const WeldedTriangle &a, const WeldedTriangle &b) {
        return a.vertices == b.vertices;
    };
    triangles.erase(std::unique(triangles.begin(), triangles.end(), is_same), triangles.end());
    std::ranges::sort(triangles, {}, &WeldedTriangle::triangle);
    return before - triangles.size();
}

[[nodiscard]] std::array<Vector3, 3> corners_m(const TriangleSoup &soup,
                                               const VertexTriple &vertices) {
    return {soup.vertices_m[vertices[0]], soup.vertices_m[vertices[1]],
            soup.vertices_m[vertices[2]]};
}

/// Closed components whose triangles face the volume that they enclose.
[[nodiscard]] std::size_t count_inward(const TriangleSoup &soup,
                                       const std::vector<VertexTriple> &triangles,
                                       const MeshTopology &topology) {
    // Six times the signed volume, from the tetrahedra to a point near the mesh.
    std::vector<double> volumes(topology.is_closed.size(), 0.0);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const Vector3 &origin = soup.vertices_m[triangles.front()[0]];
        const auto [a, b, c] = corners_m(soup, triangles[i]);
        volumes[topology.component_of_triangle[i]] +=
            (a - origin).dot((b - origin).cross(c - origin));
    }
    std::size_t inward = 0;
    for (std::size_t component = 0; component < volumes.size(); ++component) {
        inward += topology.is_closed[component] && volumes[component] < 0.0 ? 1 : 0;
    }
    return inward;
}

} // namespace

PreparedMesh prepare_mesh(const TriangleSoup &soup) {
    require_consistent(soup);
    PreparedMesh mesh;
    MeshReport &report = mesh.report;
    report.triangles_given = soup.triangles.size();

    const std::vector<std::uint32_t> stands_for = weld_vertices(soup.vertices_m, kWeldTolerance_m);
    for (std::uint32_t vertex = 0; vertex < stands_for.size(); ++vertex) {
        report.welded_vertices += stands_for[vertex] == vertex ? 0 : 1;
    }
    std::vector<WeldedTriangle> welded = welded_triangles(soup, stands_for);
    report.degenerate_triangles = soup.triangles.size() - welded.size();
    report.duplicate_triangles = remove_duplicates(welded);

    // Slivers belong to the topology, or a surface with a sliver in it would count as open.
    std::vector<VertexTriple> triples(welded.size());
    std::ranges::transform(welded, triples.begin(), &WeldedTriangle::vertices);
    const MeshTopology topology = find_topology(triples);
    report.open_edges = topology.open_edges;
    report.non_manifold_edges = topology.non_manifold_edges;
    report.components = topology.is_closed.size();
    report.closed_components =
        static_cast<std::size_t>(std::ranges::count(topology.is_closed, true));
    report.inward_components = count_inward(soup, triples, topology);

    mesh.facets.reserve(welded.size());
    for (std::size_t i = 0; i < welded.size(); ++i) {
        const std::array<Vector3, 3> corners = corners_m(soup, welded[i].vertices);
        if (smallest_height_m(corners) < kSmallestHeight_m) {
            ++report.degenerate_triangles;
            continue;
        }
        const bool bounds_volume = topology.is_closed[topology.component_of_triangle[i]];
        mesh.facets.push_back(
            {corners, bounds_volume ? FacetSides::one : FacetSides::two, welded[i].triangle});
    }
    report.left_out_of_material.assign(soup.materials.size(), 0);
    for (const std::uint16_t material : soup.material_of_triangle) {
        ++report.left_out_of_material[material];
    }
    for (const FacetSource &facet : mesh.facets) {
        --report.left_out_of_material[soup.material_of_triangle[facet.triangle]];
    }
    report.triangles_kept = mesh.facets.size();
    return mesh;
}

} // namespace springdrive
