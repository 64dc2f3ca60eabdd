// Keeps what is drawn in pieces that reach the graphics card within a frame.
#pragma once

#include "engine/scene/scene.h"

#include <cstddef>
#include <vector>

namespace springdrive::scene {

/// No piece has more vertices, or more than twice as many triangles: 10 MB, or 10 ms to upload even
/// where OpenGL runs in software.
inline constexpr std::size_t kMaxPieceVertices = 131'072;

/// The same triangles in the same order in as few meshes as it takes; a mesh that is small enough
/// comes back as it is. Vertices that several pieces use are repeated.
[[nodiscard]] std::vector<VisualMesh> in_pieces(VisualMesh mesh,
                                                std::size_t max_vertices = kMaxPieceVertices);

} // namespace springdrive::scene
