// Where a hand leads the tip over the test surfaces, a place for each servo tick.
#pragma once

#include "base/vector.h"

#include <vector>

namespace springdrive::bench {

enum class Relief { smooth, bumpy };

inline constexpr double kServoPeriod_s = 1e-3;

/// Unit vectors along a Lissajous figure of longitude and latitude, which at a sphere of
/// `kTestSphereRadius_m` is gone along at 0.1 m/s in the mean.
[[nodiscard]] std::vector<Vector3> lissajous_directions(int updates);

/// Tips 1 to 2 mm under the true surface in these directions.
[[nodiscard]] std::vector<Vector3> pressed_tips_m(Relief relief,
                                                  const std::vector<Vector3> &directions);

/// Tips 5 to 20 mm off the surface.
[[nodiscard]] std::vector<Vector3> free_tips_m(Relief relief,
                                               const std::vector<Vector3> &directions);

} // namespace springdrive::bench
