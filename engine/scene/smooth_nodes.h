// Bends the nodes that ask for it into the surfaces that their normals describe.
#pragma once

#include "engine/scene/gltf_mesh.h"

#include <string>
#include <vector>

namespace springdrive::scene::gltf {

/// Neighbouring facets of a smooth node differ by no more than this: the finger takes it for round.
inline constexpr double kSmooth_deg = 0.5;

/// All smooth nodes of a scene together become no more triangles than this.
inline constexpr std::size_t kMaxCurvedTriangles = 2'000'000;

/// Replaces the primitives of smooth nodes by curved, finely cut ones; all primitives of a node are
/// cut alike, so that they stay joined. Where the scene's allowance does not suffice, all are cut
/// more coarsely, and `remarks` tells how far neighbouring facets differ then.
/// @throw InputError naming the node, when a smooth one has no normals, or some without direction.
void bend_smooth_nodes(std::vector<PlacedPrimitive> &primitives, std::vector<std::string> &remarks);

} // namespace springdrive::scene::gltf
