// Turns triangles so that neighbours agree which side is out.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/edge_table.h"
#include "engine/contact/mesh/mesh_triangle.h"

#include <cstddef>
#include <vector>

namespace springdrive::contact {

struct TurnedTriangles {
    std::size_t of_one_winding = 0;
    std::size_t of_both = 0; ///< which makes no difference but to the edges
};

/// Turns triangles so that any two that alone share an edge run through it in opposite directions.
///
/// Within each patch (connected over such edges) the winding of a clear majority of the area
/// stays: two thirds of it or more are the author's choice, also that of a room seen from within,
/// with a few faces turned by mistake. With less than that nobody has chosen, and the patch is
/// turned to face away from its middle; one that has no inside keeps the winding of the larger
/// part. Patches that cannot be made to agree, as a Möbius strip, stay as they are.
/// @param edges those of `triangles`; no longer true if anything was turned
[[nodiscard]] TurnedTriangles orient_triangles(std::vector<MeshTriangle> &triangles,
                                               const EdgeTable &edges,
                                               const std::vector<Vector3> &vertices_m);

} // namespace springdrive::contact
