// What to touch, by name: a glTF file or a surface whose true shape is known.
#pragma once

#include "engine/scene/load_progress.h"
#include "engine/scene/scene.h"

#include <string>

namespace springdrive::rig {

/// Loads a file as `load_gltf` does, or makes what `test_surface_named` knows, in metres about the
/// origin and with nothing to draw.
/// @throw InputError as these do.
/// @param progress receives the progress, if given
[[nodiscard]] scene::Scene touch_scene(const std::string &name, const device::Workspace &workspace,
                                       scene::LoadProgress *progress = nullptr);

} // namespace springdrive::rig
