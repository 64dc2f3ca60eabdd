// The surfaces that a scene can be touched as.
#pragma once

#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/model_selection/model.h"
#include "engine/scene/scene.h"

#include <vector>

namespace springdrive::model_selection {

/// What may stand for the scene's surface, from the simplest on; the last is what it asks for.
/// Simplified meshes halve their triangles from one to the next for as long as that goes.
[[nodiscard]] std::vector<ContactShape> contact_shapes_of(const scene::Scene &scene);

/// The scene's surface as that shape, prepared for touch. Nodes that no primitive fits keep their
/// triangles.
/// @throw InputError for a shape that the scene cannot be touched as: no node is a primitive, or
///        none is smooth.
[[nodiscard]] contact::HapticSurface haptic_surface_of(const scene::Scene &scene,
                                                       const ContactShape &shape);

} // namespace springdrive::model_selection
