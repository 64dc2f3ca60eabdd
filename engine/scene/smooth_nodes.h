// Curves the nodes that are marked smooth to the surfaces that their normals describe.
#pragma once

#include "engine/scene/gltf_mesh.h"

#include <string>
#include <vector>

namespace springdrive::scene::gltf {

/// The largest angle between neighbouring facets of a smooth node, too small to be felt.
inline constexpr double kSmooth_deg = 0.5;

/// The maximum number of triangles of all smooth nodes of a scene together.
inline constexpr std::size_t kMaxCurvedTriangles = 2'000'000;

/// Replaces the primitives of smooth nodes by curved, finely divided ones; all primitives of a node
/// are divided alike, so that they stay joined. If this would exceed `kMaxCurvedTriangles`, all are
/// divided more coarsely, and `warnings` states the resulting angle between neighbouring facets.
/// Nodes without normals stay as they are, with a warning.
/// @throw InputError naming the node if a smooth one has normals of length zero.
void bend_smooth_nodes(std::vector<PlacedPrimitive> &primitives, WarningList &warnings);

} // namespace springdrive::scene::gltf
