// What the "extras" of a glTF's scene, or of its asset, say of the scene as a whole. The keys are
// those that `load_gltf` documents.
#pragma once

#include "engine/scene/lesson.h"
#include "engine/scene/model_tolerance.h"
#include "engine/scene/warning_list.h"

namespace tinygltf {
class Model;
}

namespace springdrive::scene::gltf {

struct SceneExtras {
    bool in_metres = false; ///< coordinates are metres in the device's frame
    bool planar = false;    ///< the hand stays in the linkage's plane
    ModelTolerance tolerance;
    Lesson lesson; ///< its spot in the file's coordinates
};

/// Of the asset and of the scene that `place_meshes` takes; the scene's values come first.
/// @param warnings gains what is left out as another program's, see `Extras`
/// @throw InputError for a value of a wrong type or out of range in a `tolerance` or a `lesson`
///        that has any of its keys, for a key there that is none, and for a lesson with a point but
///        no normal, or the reverse.
[[nodiscard]] SceneExtras read_scene_extras(const tinygltf::Model &model, WarningList &warnings);

} // namespace springdrive::scene::gltf
