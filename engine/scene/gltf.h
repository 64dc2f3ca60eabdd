// glTF 2.0 files (.gltf, .glb) to scenes.
#pragma once

#include "engine/scene/scene.h"

#include <filesystem>

namespace springdrive {

/// Loads a glTF file and places it in the device's frame.
///
/// Fitted uniformly, largest that fits into 60 % of the workspace, centred there, unless the
/// file's scene or asset says `"extras": {"units": "m"}`: then its coordinates are metres in the
/// device frame as they stand. A node's `"extras": {"eta": 0.5}` sets η of what it holds (and of
/// its children, unless they say otherwise); the default is 0, rigid.
///
/// @throw InputError with one line that names the file, what is wrong in it and where: for a file
///        that is missing, is no glTF, is truncated, refers outside its buffers or arrays, holds
///        coordinates that are not finite, needs an extension that we lack, or has no triangle.
[[nodiscard]] Scene load_gltf(const std::filesystem::path &file, const Workspace &workspace);

} // namespace springdrive
