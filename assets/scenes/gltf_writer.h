// Writes scenes as .gltf text with all data embedded.
#pragma once

#include "assets/scenes/shapes.h"

#include <string>

namespace springdrive::scenes {

/// The scene as glTF 2.0: one node, mesh and material per part; the same bytes on every machine.
[[nodiscard]] std::string to_gltf(const SceneDescription &scene);

} // namespace springdrive::scenes
