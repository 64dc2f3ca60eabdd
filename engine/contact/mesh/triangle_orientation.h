// Turns triangles so that neighbours agree on which side is out.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/edge_table.h"
#include "engine/contact/mesh/mesh_triangle.h"

#include <cstddef>
#include <vector>

namespace springdrive::contact {

struct TurnedTriangles {
    std::size_t of_one_winding = 0;
    std::size_t of_both = 0; ///< which only changes their edges
};

/// Turns triangles so that any two that alone share an edge traverse it in opposite directions.
///
/// Within each patch (connected over such edges) the winding of a clear majority of the area stays:
/// two thirds or more are taken as the author's choice, as for a room seen from within, with a few
/// faces turned by mistake. With less than that the winding is taken as arbitrary, and the patch is
/// turned to face away from its middle; one that has no inside keeps the winding of the larger
/// part. Patches that cannot be made consistent, such as a Möbius strip, stay as they are.
/// @param edges those of `triangles`; no longer valid if anything was turned
[[nodiscard]] TurnedTriangles orient_triangles(std::vector<MeshTriangle> &triangles,
                                               const EdgeTable &edges,
                                               const std::vector<Vector3> &vertices_m);

} // namespace springdrive::contact
