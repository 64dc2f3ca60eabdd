// What a glTF's scene or asset says in its "extras": of all of it, not of a node.
#pragma once

#include "engine/scene/model_tolerance.h"

namespace tinygltf {
class Model;
}

namespace springdrive::scene::gltf {

struct SceneExtras {
    bool in_metres = false; ///< coordinates are metres in the device's frame
    bool planar = false;    ///< the hand stays in the linkage's plane
    ModelTolerance tolerance;
};

/// Of the asset and of the scene that `place_meshes` takes; what the scene says counts. The keys
/// are those that `load_gltf` documents.
/// @throw InputError for a value of a wrong type, out of range or unknown, and for a key in
///        `tolerance` that is none.
[[nodiscard]] SceneExtras read_scene_extras(const tinygltf::Model &model);

} // namespace springdrive::scene::gltf
