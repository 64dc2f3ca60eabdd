// Which triangles hang together over shared edges, and whether they enclose a volume.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace springdrive {

/// Three welded vertex indices, in winding order, all different.
using VertexTriple = std::array<std::uint32_t, 3>;

struct MeshTopology {
    std::vector<std::uint32_t> component_of_triangle;
    /// For each component. Closed: every edge is run through as often forwards as backwards. That
    /// holds for closed surfaces of one consistent winding, also where two of them share an edge,
    /// as voxels do, and is what makes "inside" a meaningful word.
    std::vector<bool> is_closed;
    std::size_t open_edges = 0;         ///< used by one triangle only
    std::size_t non_manifold_edges = 0; ///< used by more than two triangles
};

[[nodiscard]] MeshTopology find_topology(const std::vector<VertexTriple> &triangles);

} // namespace springdrive
