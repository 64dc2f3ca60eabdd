// Everything of a glTF that has triangles, where its nodes place it.
#pragma once

#include "engine/scene/gltf_mesh.h"
#include "engine/scene/load_progress.h"

#include <string>
#include <vector>

namespace springdrive::scene::gltf {

/// The primitives of all nodes, those of one node together, in the file's own world coordinates.
/// `remarks` gains what cannot be touched or drawn.
/// @param nodes are pointed at by the result
/// @throw InputError naming the node, for what cannot be read, is not finite or is too much.
[[nodiscard]] std::vector<PlacedPrimitive> gather(const tinygltf::Model &model,
                                                  const std::vector<PlacedMesh> &nodes,
                                                  std::vector<std::string> &remarks,
                                                  LoadProgress &progress);

} // namespace springdrive::scene::gltf
