// What is drawn of a scene besides its meshes as they are: the lines in which a surface turns
// sharply or ends, so that steps are seen from above, too; pieces that reach the graphics card
// within a frame; and textures that are not larger than it can hold.
#pragma once

#include "engine/scene/scene.h"

#include <cstddef>
#include <span>
#include <vector>

namespace springdrive::scene {

/// An edge is a crease where the drawn normals of its triangles differ by more at either end.
inline constexpr double kCrease_deg = 30.0;

/// A mesh with more triangles, or a scene with more creases, has none: its edges lie too close for
/// lines to explain them, and a software renderer takes long.
inline constexpr std::size_t kMaxCreasedTriangles = 100'000;
inline constexpr std::size_t kMaxCreases = 4'000;

/// Creases and borders of all meshes that are opaque and have no texture or mask, which would show
/// their own edges. Vertices at the same place, to the last bit, count as one, whichever mesh they
/// are of.
[[nodiscard]] std::vector<LineSegment> creases_of(std::span<const VisualMesh> meshes);

/// No piece has more vertices, or more than twice as many triangles: 10 MB, or 10 ms to upload even
/// where OpenGL runs in software.
inline constexpr std::size_t kMaxPieceVertices = 131'072;

/// The same triangles in the same order in as few meshes as it takes; a mesh that is small enough
/// comes back as it is. Vertices that several pieces use are repeated.
[[nodiscard]] std::vector<VisualMesh> in_pieces(VisualMesh mesh,
                                                std::size_t max_vertices = kMaxPieceVertices);

/// The texture with at most `max_side` pixels a side, each the mean of those that it covers; as it
/// is if it has no more. @pre max_side > 0
[[nodiscard]] Texture scaled_down(const Texture &texture, int max_side);

} // namespace springdrive::scene
