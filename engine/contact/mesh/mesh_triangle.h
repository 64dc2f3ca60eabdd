// A triangle during mesh preparation.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace springdrive::contact {

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
