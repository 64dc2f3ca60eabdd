// A touchable surface with fewer triangles.
#pragma once

#include "engine/contact/mesh/triangle_soup.h"

namespace springdrive::model_selection {

/// Each node's triangles reduced to a `divisor`th of their number, or to as few as its topology
/// allows: edges are collapsed where that moves the surface least (meshoptimizer). Closed surfaces
/// stay closed, and materials are kept.
/// @pre divisor >= 1
[[nodiscard]] contact::TriangleSoup simplified(const contact::TriangleSoup &soup, int divisor);

} // namespace springdrive::model_selection
