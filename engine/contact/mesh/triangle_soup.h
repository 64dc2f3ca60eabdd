// The touchable triangles of a scene as its file gives them, before preparation.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/surface_material.h"

#include <array>
#include <cstdint>
#include <vector>

namespace springdrive::contact {

/// Triangles as a scene file gives them. Wound counter-clockwise seen from outside, as in glTF.
struct TriangleSoup {
    std::vector<Vector3> vertices_m;
    std::vector<std::array<std::uint32_t, 3>> triangles; ///< indices into `vertices_m`
    std::vector<std::uint16_t> material_of_triangle;     ///< index into `materials`
    std::vector<SurfaceMaterial> materials;
};

} // namespace springdrive::contact
