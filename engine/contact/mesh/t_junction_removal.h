// Closes T-junctions: where one triangle's side runs along several sides of others, whose vertices
// lie on it only up to round-off.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/edge_table.h"
#include "engine/contact/mesh/mesh_triangle.h"
#include "engine/contact/mesh/preparation_allowance.h"

#include <cstddef>
#include <vector>

namespace springdrive::contact {

struct SplitEdges {
    std::size_t split_triangles = 0;
    double largest_move_m = 0.0; ///< of a point of an edge
};

/// Routes open edges through the ends of other open edges that lie within the tolerance of their
/// interiors, and divides their triangles accordingly. The pieces are appended to `triangles`,
/// except one that replaces the whole, and keep its index in the soup.
/// @param edges those of `triangles`; no longer valid if anything was split
/// @param threads the maximum number used; the result is the same for any number
/// @pre tolerance_m > 0, threads > 0
/// @throw InputError where it needs more steps than allowed; nothing was divided then
[[nodiscard]] SplitEdges split_edges(std::vector<MeshTriangle> &triangles, const EdgeTable &edges,
                                     const std::vector<Vector3> &vertices_m, double tolerance_m,
                                     PreparationAllowance &allowance, unsigned threads);

} // namespace springdrive::contact
