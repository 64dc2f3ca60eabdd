// The touchable triangles of a scene as its file gives them, before preparation.
#pragma once

#include "base/vector.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace springdrive {

/// What is felt on the triangles of one glTF node.
struct SurfaceMaterial {
    std::string name; ///< the node's name, for messages
    double eta = 0.0; ///< η of (30): 0 rigid, 1 free space
};

/// Triangles as a scene file gives them. Wound counter-clockwise seen from outside, as in glTF.
struct TriangleSoup {
    std::vector<Vector3> vertices_m;
    std::vector<std::array<std::uint32_t, 3>> triangles; ///< indices into `vertices_m`
    std::vector<std::uint16_t> material_of_triangle;     ///< index into `materials`
    std::vector<SurfaceMaterial> materials;
};

} // namespace springdrive
