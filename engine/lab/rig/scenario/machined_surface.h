// A part as a CAD system exports it: flat faces in few triangles, fillets and cylinders in many.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/triangle_soup.h"

#include <cstddef>

namespace springdrive::rig {

/// A block of 50 mm, its edges and corners rounded by 1 mm, with a stub shaft of 18 mm radius and
/// 20 mm length on both faces along x, rounded at its end and filleted at its foot. With a million
/// triangles:
///   edges of the block       2 × 200 needles of 1 : 6000 each
///   corners of the block     40,000 triangles of 8 µm each
///   flat faces along y and z two triangles
///   flat faces along x       fans of 3000 needles at each corner, up to 1 : 13,000, to the foot
///   fillets, rounded ends    12,000 × 6 × 2 triangles of 9 µm × 0.3 to 0.4 mm each
///   cylinders                2 × 12,000 needles of 1 : 1900 each
///   ends                     a fan of 12,000 needles: one about its middle, one from its rim
/// Closed, wound outwards, vertices shared. No ray from the origin meets it twice.
/// @param triangles  about; larger numbers are met more closely
[[nodiscard]] contact::TriangleSoup machined_surface(std::size_t triangles);

/// How far its true shape is from the origin in a direction of length 1.
[[nodiscard]] double machined_body_radius_m(const Vector3 &direction);

} // namespace springdrive::rig
