// Which triangles are connected over shared edges, and which volumes they enclose.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/edge_table.h"
#include "engine/contact/mesh/mesh_triangle.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace springdrive::contact {

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
