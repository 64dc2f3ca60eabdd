// Textures that are larger than a graphics card can hold.
#pragma once

#include "engine/scene/scene.h"

namespace springdrive::scene {

/// The texture with at most `max_side` pixels a side, each the mean of those that it covers; as it
/// is if it has no more. @pre max_side > 0
[[nodiscard]] Texture scaled_down(const Texture &texture, int max_side);

} // namespace springdrive::scene
