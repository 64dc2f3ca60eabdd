// A scene's surface, prepared for touch.
#pragma once

#include "engine/contact/proxy/haptic_surface.h"
#include "engine/scene/scene.h"

namespace springdrive::scene {

/// Prepares the haptic surface of a scene.
/// @throw InputError naming the file, if none of its triangles can be touched, or for what takes
///        too many steps or too much memory.
[[nodiscard]] contact::HapticSurface haptic_surface_of(const Scene &scene);

} // namespace springdrive::scene
