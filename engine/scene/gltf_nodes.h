// The node graph of a glTF, flattened, and what its "extras" say: which meshes are placed where,
// and how they feel. The keys are those that `load_gltf` documents.
#pragma once

#include "engine/contact/mesh/surface_material.h"
#include "engine/scene/shape_fit.h"
#include "engine/scene/warning_list.h"

#include <Eigen/Geometry>

#include <optional>
#include <string>
#include <vector>

namespace tinygltf {
class Model;
}

namespace springdrive::scene::gltf {

/// What a node's extras say about touch. All but `shape` and `caption` pass from a node to its
/// children.
struct TouchExtras {
    contact::SurfaceMaterial material;
    bool smooth = false;            ///< touched and drawn as the curved surface of its normals
    std::optional<ShapeKind> shape; ///< touched as this instead of as its triangles
    std::string caption;            ///< shown on it; may be empty
};

/// A node's touch. A node that gives one coefficient of friction gives both: the other is the same.
/// @param text JSON of its extras
/// @param parent what its parent passes on
/// @param label of the node, for messages
/// @param warnings gains the values of a wrong type, out of range or unknown: another program's,
///        which may use the same names; they are left out
/// @throw InputError for dynamic friction above static, and for a shape that cannot be touched from
///        the sides that it asks for.
[[nodiscard]] TouchExtras read_touch(const std::string &text, const TouchExtras &parent,
                                     const std::string &label, WarningList &warnings);

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
