#include "engine/contact/mesh/surface_facets.h"

#include "base/cancellation.h"
#include "base/parallel.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace springdrive::contact {

namespace {

[[nodiscard]] std::array<Vector3, 3> corners_m(const MeshTriangle &triangle,
                                               const std::vector<Vector3> &vertices_m) {
    const auto &[a, b, c] = triangle.vertices;
    return {vertices_m[a], vertices_m[b], vertices_m[c]};
}

struct Sliver {
    std::uint32_t index = 0;
    bool has_normal = true;
};

[[nodiscard]] std::vector<Sliver> find_slivers(const std::vector<MeshTriangle> &triangles,
                                               const std::vector<Vector3> &vertices_m,
                                               unsigned threads) {
    std::vector<std::vector<Sliver>> slivers_of_chunk(threads);
    in_chunks(triangles.size(), threads, [&](unsigned chunk, std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            stop_if_given_up(i);
            // True for a height that is not finite too.
            const double height_m = min_height_m(corners_m(triangles[i], vertices_m));
            if (!(height_m >= kMinHeight_m)) {
                slivers_of_chunk[chunk].push_back(
                    {static_cast<std::uint32_t>(i), height_m >= kMinNormalHeight_m});
            }
        }
    });
    std::vector<Sliver> slivers;
    for (const std::vector<Sliver> &some : slivers_of_chunk) {
        slivers.insert(slivers.end(), some.begin(), some.end());
    }
    return slivers;
}

[[nodiscard]] FacetSides sides_of(const MeshTriangle &triangle, const MeshComponent &component,
                                  TouchSides wanted) {
    const bool is_one_sided =
        wanted == TouchSides::one || (wanted == TouchSides::automatic && component.is_closed);
    return is_one_sided && !triangle.has_both_windings ? FacetSides::one : FacetSides::two;
}

} // namespace

std::vector<std::uint32_t> slivers_to_leave_out(const std::vector<MeshTriangle> &triangles,
                                                const EdgeTable &edges,
                                                const std::vector<Vector3> &vertices_m,
                                                unsigned threads) {
    const std::vector<Sliver> slivers = find_slivers(triangles, vertices_m, threads);
    // By edge, so that many slivers at one edge do not look at each other.
    std::vector<bool> has_gap(slivers.empty() ? 0 : edges.uses());
    const auto leave_gap = [&](const VertexTriple &vertices) {
        for (std::size_t side = 0; side < 3; ++side) {
            has_gap[edges.first_use_of(vertices[side], vertices[(side + 1) % 3])] = true;
        }
    };
    const auto has_gap_beside = [&](const VertexTriple &vertices) {
        for (std::size_t side = 0; side < 3; ++side) {
            if (has_gap[edges.first_use_of(vertices[side], vertices[(side + 1) % 3])]) {
                return true;
            }
        }
        return false;
    };
    for (const Sliver &sliver : slivers) {
        if (!sliver.has_normal) {
            leave_gap(triangles[sliver.index].vertices);
        }
    }
    std::vector<std::uint32_t> left_out;
    for (const Sliver &sliver : slivers) {
        const VertexTriple &vertices = triangles[sliver.index].vertices;
        if (!sliver.has_normal || !has_gap_beside(vertices)) {
            leave_gap(vertices);
            left_out.push_back(sliver.index);
        }
    }
    return left_out;
}

std::vector<FacetSource> make_facets(const std::vector<MeshTriangle> &triangles,
                                     const std::vector<std::uint32_t> &left_out,
                                     const MeshTopology &topology, const TriangleSoup &soup,
                                     unsigned threads) {
    std::vector<FacetSource> facets(triangles.size() - left_out.size());
    in_chunks(triangles.size(), threads, [&](unsigned, std::size_t first, std::size_t last) {
        auto next_left_out = std::ranges::lower_bound(left_out, first);
        auto facet = facets.begin() + static_cast<std::ptrdiff_t>(first) -
                     (next_left_out - left_out.begin());
        for (std::size_t i = first; i < last; ++i) {
            stop_if_given_up(i);
            if (next_left_out != left_out.end() && *next_left_out == i) {
                ++next_left_out;
                continue;
            }
            const MeshTriangle &triangle = triangles[i];
            const MeshComponent &component = topology.components[topology.component_of_triangle[i]];
            const std::uint16_t material = soup.material_of_triangle[triangle.triangle];
            *facet++ = {corners_m(triangle, soup.vertices_m),
                        sides_of(triangle, component, soup.materials[material].sides),
                        triangle.triangle, material};
        }
    });
    return facets;
}

} // namespace springdrive::contact
