// Paths of the tip over the test surfaces, one point for each servo tick.
#pragma once

#include "base/vector.h"

#include <vector>

namespace springdrive::bench {

/// That of `sphere:N`, `bumpy:N`, `scan:N` and `cad:N`.
enum class Relief { smooth, bumpy, scanned, machined };

inline constexpr double kServoPeriod_s = 1e-3;

/// Unit vectors along a Lissajous figure of longitude and latitude, which on a sphere of
/// `kTestSphereRadius_m` has a mean speed of 0.1 m/s.
[[nodiscard]] std::vector<Vector3> lissajous_directions(int updates);

/// Tips 1 to 2 mm under the true surface in these directions; over the holes of a scan the tip is
/// lifted off it, so that the proxy does not get inside.
[[nodiscard]] std::vector<Vector3> pressed_tips_m(Relief relief,
                                                  const std::vector<Vector3> &directions);

/// Tips 5 to 20 mm off the surface.
[[nodiscard]] std::vector<Vector3> free_tips_m(Relief relief,
                                               const std::vector<Vector3> &directions);

} // namespace springdrive::bench
