// The alternative touchable surfaces of a scene.
#pragma once

#include "engine/contact/mesh/triangle_soup.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/scene/scene.h"
#include "engine/session/model/model_selection.h"

#include <vector>

namespace springdrive::model_selection {

/// The alternatives to the scene's surface, the simplest first; the last is the one that the scene
/// specifies. Simplified meshes halve their triangles from one to the next as long as that is
/// possible.
[[nodiscard]] std::vector<ContactShape> contact_shapes_of(const scene::Scene &scene);

/// The scene's surface in that form, prepared for touch. Nodes that no primitive fits keep their
/// triangles.
/// @throw InputError for a shape that the scene cannot be touched as: no node is a primitive, or
///        none is smooth.
[[nodiscard]] contact::HapticSurface haptic_surface_of(const scene::Scene &scene,
                                                       const ContactShape &shape);

/// A touchable surface with fewer triangles: each node's triangles reduced to a `divisor`th of
/// their number, or to as few as its topology allows: edges are collapsed where that moves the
/// surface least (meshoptimizer). Closed surfaces stay closed, and materials are kept.
/// @pre divisor >= 1
[[nodiscard]] contact::TriangleSoup simplified(const contact::TriangleSoup &soup, int divisor);

} // namespace springdrive::model_selection
