// The node graph of a glTF, flattened: which meshes are placed where, and how they feel.
#pragma once

#include "engine/scene/gltf_extras.h"
#include "engine/scene/warning_list.h"

#include <Eigen/Geometry>

#include <string>
#include <vector>

namespace tinygltf {
class Model;
}

namespace springdrive::scene::gltf {

/// A node that holds a mesh.
struct PlacedMesh {
    std::string name;  ///< the node's, else the mesh's, else "node 3"
    std::string label; ///< for messages: "node 'name'" or "node 3"
    int mesh = -1;     ///< index into the model's meshes
    Eigen::Affine3d to_world{Eigen::Affine3d::Identity()};
    TouchExtras touch; ///< its material's name is `name`
    bool has_skin = false;
};

/// The meshes of the default scene, depth first in the file's order. Without a default the first
/// scene is taken; without any scene, every node that has no parent.
/// @throw InputError naming the node: for a graph that is no tree, references to what does not
///        exist, transforms that are not finite or no affine maps, rotations that are no unit
///        quaternions, and extras as `read_touch` refuses them.
[[nodiscard]] std::vector<PlacedMesh> place_meshes(const tinygltf::Model &model,
                                                   WarningList &warnings);

} // namespace springdrive::scene::gltf
