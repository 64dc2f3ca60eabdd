// The touchable triangles of a scene: as its file gives them, and during their preparation.
#pragma once

#include "base/vector.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace springdrive::contact {

/// The sides from which a surface can be touched.
enum class TouchSides : std::uint8_t {
    automatic, ///< from outside only if it is closed, from both sides if it is open
    one,       ///< from the side that its normals point to
    two,       ///< from both
};

/// Haptic material of one glTF node, as its scene specifies it.
struct SurfaceMaterial {
    std::string name;              ///< the node's name, for messages
    double eta = 0.0;              ///< η of (30): 0 rigid, 1 free space
    double static_friction = 0.0;  ///< Coulomb coefficient while sticking
    double dynamic_friction = 0.0; ///< coefficient while sliding; not above the static one
    TouchSides sides = TouchSides::automatic;
};

/// Triangles as a scene file gives them. Wound counter-clockwise seen from outside, as in glTF.
struct TriangleSoup {
    std::vector<Vector3> vertices_m;
    std::vector<std::array<std::uint32_t, 3>> triangles; ///< indices into `vertices_m`
    std::vector<std::uint16_t> material_of_triangle;     ///< index into `materials`
    std::vector<SurfaceMaterial> materials;
};

/// Three vertex indices, in winding order.
using VertexTriple = std::array<std::uint32_t, 3>;

/// Meshes of more triangles than this are refused.
inline constexpr std::size_t kMaxTriangles = std::size_t{1} << 29;

/// A triangle of welded vertices, all different, and where it came from.
struct MeshTriangle {
    VertexTriple vertices{};
    std::uint32_t triangle = 0;     ///< its index in the soup
    bool has_both_windings = false; ///< stands for itself and for its other side
};

} // namespace springdrive::contact
