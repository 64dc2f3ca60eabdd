// Paths of the tip over the test surfaces, one point for each servo tick.
#pragma once

#include "base/vector.h"

#include <vector>

namespace springdrive::bench {

enum class Relief { smooth, bumpy };

inline constexpr double kServoPeriod_s = 1e-3;

/// Unit vectors along a Lissajous figure of longitude and latitude, which on a sphere of
/// `kTestSphereRadius_m` has a mean speed of 0.1 m/s.
[[nodiscard]] std::vector<Vector3> lissajous_directions(int updates);

/// Tips 1 to 2 mm under the true surface in these directions.
[[nodiscard]] std::vector<Vector3> pressed_tips_m(Relief relief,
                                                  const std::vector<Vector3> &directions);

/// Tips 5 to 20 mm off the surface.
[[nodiscard]] std::vector<Vector3> free_tips_m(Relief relief,
                                               const std::vector<Vector3> &directions);

} // namespace springdrive::bench
