// Which triangles hang together over shared edges, and whether they enclose a volume.
#pragma once

#include "engine/contact/mesh/edge_table.h"
#include "engine/contact/mesh/mesh_triangle.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace springdrive::contact {

/// Triangles connected over edges.
///
/// Closed: every edge is run through as often forwards as backwards. That holds for closed
/// surfaces of one consistent winding, also where two of them share an edge, as voxels do, and is
/// what makes "inside" a meaningful word. Triangles of both windings count either not at all, as
/// sheets within or on a solid, or all of them as what they are wound like.
struct MeshComponent {
    bool is_closed = true;
    bool is_orientable = true; ///< false: two triangles at an edge cannot agree which side is out
    /// Of a closed one, whether triangles of both windings are no part of what encloses it.
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

} // namespace springdrive::contact
