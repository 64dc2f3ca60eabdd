// A surface as a range scanner measures it: points at random, noise, holes.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/triangle_soup.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace springdrive::rig {

/// A cone from the origin in which nothing was measured; its rim in the mesh is ragged.
struct ScanHole {
    Vector3 direction;
    double half_angle_rad;
};

/// By how much the rim of a hole may lie outside its cone.
inline constexpr double kMaxRaggedness_rad = 0.02;

/// The body of `organic_shape`, `kTestOrganicScale_m` times its size, measured from outside: about
/// that many triangles between points at random, ten times as dense in some parts as in others;
/// noise of 20 µm (rms) at wavelengths from 8 mm to 0.13 mm; one triangle in 200 a sliver of 1 : 10
/// to 1 : 1000. Open below and at the holes, wound outwards, vertices shared. No ray from the
/// origin meets it twice. The same for the same arguments.
[[nodiscard]] contact::TriangleSoup scanned_surface(std::size_t triangles, std::uint64_t seed);

/// Those of that seed: the open underside first, then 20 of 0.2 to 2 mm in radius.
[[nodiscard]] std::vector<ScanHole> scan_holes(std::uint64_t seed);

/// How far the body is from the origin in a direction of length 1, without noise and holes.
[[nodiscard]] double scanned_body_radius_m(const Vector3 &direction);

} // namespace springdrive::rig
