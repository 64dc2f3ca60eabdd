// What the "extras" of a glTF's nodes, of its scene and of its asset say. The keys are those that
// `load_gltf` documents.
#pragma once

#include "engine/contact/mesh/surface_material.h"
#include "engine/scene/lesson.h"
#include "engine/scene/model_tolerance.h"
#include "engine/scene/shape_fit.h"
#include "engine/scene/warning_list.h"

#include <optional>
#include <string>

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

class Model;
} // namespace springdrive::scene::gltf

namespace springdrive::scene::gltf {

struct SceneExtras {
    bool in_metres = false; ///< coordinates are metres in the device's frame
    bool planar = false;    ///< the hand stays in the linkage's plane
    ModelTolerance tolerance;
    Lesson lesson; ///< its spot in the file's coordinates
};

/// Of the asset and of the scene that `place_meshes` takes; the scene's values come first.
/// @param warnings gains what is left out as another program's, as above
/// @throw InputError for a value of a wrong type or out of range in a `tolerance` or a `lesson`
///        that has any of its keys, for a key there that is none, and for a lesson with a point but
///        no normal, or the reverse.
[[nodiscard]] SceneExtras read_scene_extras(const tinygltf::Model &model, WarningList &warnings);

} // namespace springdrive::scene::gltf
