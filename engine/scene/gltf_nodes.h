// The node graph of a glTF, flattened: which meshes are placed where, and how they feel, which
// their extras say.
#pragma once

#include "engine/contact/mesh/triangle_soup.h"
#include "engine/scene/load_messages.h"
#include "engine/scene/scene.h"
#include "engine/scene/shape_fit.h"

#include <Eigen/Geometry>

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tinygltf {
class Model;
}

namespace springdrive::scene::gltf {

// What the "extras" of a glTF's nodes, of its scene and of its asset say. The keys are those that
// `load_gltf` documents.

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

/// The number of the scene to load; −1 for a file without scenes, of which all nodes are loaded.
/// @param name  its name or number; empty: the file's default, else the first with triangles
/// @param warnings  gains the names of all, if there are several
/// @throw InputError with the names of all for a scene that the file does not have, or a name that
///        several have.
[[nodiscard]] int choose_scene(const tinygltf::Model &model, const std::string &name,
                               WarningList &warnings);

struct SceneExtras {
    bool in_metres = false; ///< coordinates are metres in the device's frame
    bool planar = false;    ///< the hand stays in the linkage's plane
    ModelTolerance tolerance;
    Lesson lesson; ///< its spot in the file's coordinates
};

/// Of the asset and of the model's default scene, or its first; the scene's values come first.
/// @param warnings gains what is left out as another program's, as above
/// @throw InputError for a value of a wrong type or out of range in a `tolerance` or a `lesson`
///        that has any of its keys, for a key there that is none, and for a lesson with a point but
///        no normal, or the reverse.
[[nodiscard]] SceneExtras read_scene_extras(const tinygltf::Model &model, WarningList &warnings);

/// Takes a mesh to the world by each joint of a skin at rest: the joint's place in the world after
/// its inverse bind matrix.
using JointTransforms = std::vector<Eigen::Affine3d>;

/// A node that holds a mesh.
struct PlacedMesh {
    std::string name;  ///< the node's, else the mesh's, else "node 3"
    std::string label; ///< for messages: "node 'name'" or "node 3"
    int mesh = -1;     ///< index into the model's meshes
    Eigen::Affine3d to_world{Eigen::Affine3d::Identity()}; ///< of a node with a skin the identity
    TouchExtras touch;                                     ///< its material's name is `name`
    std::span<const double> morph_weights; ///< at rest: the node's, else the mesh's; in the model
    int skin = -1;                         ///< index into the model's skins
    std::shared_ptr<const JointTransforms> joints{}; ///< of its skin; null: none
    /// Where a node with a skin stands, for what of its mesh the skin does not move.
    Eigen::Affine3d without_skin{Eigen::Affine3d::Identity()};
};

/// How many meshes a scene may have that has instances of one.
inline constexpr std::size_t kMaxInstances = 65'536;

/// The meshes of the model's default scene, depth first in the file's order. Without a default the
/// first scene is taken; without any scene, every node that has no parent. Each instance of a mesh
/// (EXT_mesh_gpu_instancing) is a mesh of its own.
/// @throw InputError naming the node: for a graph that is no tree, references to what does not
///        exist, transforms that are not finite or no affine maps, rotations that are no unit
///        quaternions, skins whose joints are no nodes with one place in the world, instances that
///        cannot be read or are too many, and extras as `read_touch` refuses them.
/// @param model must outlive the result
[[nodiscard]] std::vector<PlacedMesh> place_meshes(const tinygltf::Model &model,
                                                   WarningList &warnings);

} // namespace springdrive::scene::gltf
