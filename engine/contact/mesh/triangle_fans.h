// Finds fans: the triangles that meet in one vertex, each next to the one before it.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/facet.h"
#include "engine/contact/mesh/mesh_triangle.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace springdrive::contact {

/// One triangle of a fan: the edge opposite to the vertex, in winding order.
struct FanTriangle {
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    std::uint32_t apex = 0; ///< which corner of the facet is at the vertex
    std::uint32_t facet = 0;
    bool is_own = false; ///< whether it is part of this vertex' fans, and of no other's
};

/// Triangles at one vertex, each next to the one before it.
struct TriangleFan {
    Vector3 apex_m{Vector3::Zero()};
    std::vector<Vector3> rim_m;        ///< one more than triangles; the first again if it is closed
    std::vector<std::uint32_t> facets; ///< of the triangles

    /// From the apex to a point of the rim [m].
    [[nodiscard]] Vector3 spoke_m(std::size_t i) const { return rim_m[i] - apex_m; }
};

/// The triangles at each vertex where at least `min_size` of them meet; the vertices with most of
/// them first. Each is the own of one vertex only.
/// @param left_out   indices of triangles, in ascending order, that have no facet
/// @param vertices   their number
[[nodiscard]] std::vector<std::vector<FanTriangle>>
find_fan_triangles(const std::vector<MeshTriangle> &triangles,
                   const std::vector<std::uint32_t> &left_out, std::size_t vertices,
                   std::size_t min_size);

/// The fans of the triangles at one vertex that are its own, of one material and the same sides
/// each. Open ones first, then those that close.
[[nodiscard]] std::vector<TriangleFan> fans_of(std::vector<FanTriangle> triangles,
                                               const std::vector<FacetSource> &facets);

/// Parts of a fan whose spokes are about as long: of a fan from a vertex of its own outline the
/// first and the last are short. On the spoke between two parts the rings of one do not meet those
/// of the other, which leaves no gap on a straight line.
[[nodiscard]] std::vector<TriangleFan> divided_by_length(const TriangleFan &fan);

} // namespace springdrive::contact
