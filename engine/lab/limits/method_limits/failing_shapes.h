// Small surfaces on which proxies are known to fail.
#pragma once

#include "engine/contact/mesh/triangle_soup.h"

namespace springdrive::limits {

/// Two level sheets beside each other at y = 0, `gap_m` apart, the gap along z through the origin.
[[nodiscard]] contact::TriangleSoup cracked_sheet(double gap_m);

/// A pit, point down at the origin and open to +y.
/// @param faces        2 for a groove along z, 3 or more for as many triangles about the y axis
/// @param opening_rad  twice the angle between each face and the y axis
[[nodiscard]] contact::TriangleSoup pit(int faces, double opening_rad);

} // namespace springdrive::limits
