// Triangles that occur more than once are dropped, and the others turned so that neighbours agree
// on which side is out.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/mesh_topology.h"
#include "engine/contact/mesh/triangle_soup.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace springdrive::contact {

/// What was dropped, by index in the soup.
struct RepeatedTriangles {
    std::vector<std::uint32_t> same_winding; ///< another with the same vertices and winding stays
    std::vector<std::uint32_t> merged;       ///< another with the same vertices has both windings
};

/// Drops triangles that have their three vertices in common with an earlier one, and keeps the
/// order of the others. Of equal windings one is kept. A triangle and its reverse become one that
/// has both windings and is touched from both sides: the proxy cannot fall through, whether they
/// were a sheet, the wall between two solids, or part of a body given twice so as to be visible
/// from within too. Where the two sides have different materials they are left as they are, each
/// one-sided, which feels the same except for the material.
/// @param edges those of `triangles`; no longer valid if anything was dropped
/// @param material_of_triangle by index in the soup
[[nodiscard]] RepeatedTriangles
drop_repeated_triangles(std::vector<MeshTriangle> &triangles, const EdgeTable &edges,
                        const std::vector<std::uint16_t> &material_of_triangle, unsigned threads);

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
