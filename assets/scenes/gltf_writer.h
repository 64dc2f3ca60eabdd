// Scenes as .gltf text, everything embedded.
#pragma once

#include "assets/scenes/shapes.h"

#include <string>

namespace springdrive::scenes {

/// The scene as glTF 2.0: one node, mesh and material a part; the same bytes on every machine.
[[nodiscard]] std::string to_gltf(const SceneDescription &scene);

} // namespace springdrive::scenes
