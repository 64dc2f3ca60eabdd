// The plate into which tips are pressed to find where a method loses contact.
#pragma once

#include "engine/lab/limits/method_limits/method_limit.h"
#include "engine/lab/rig/scenario/test_surfaces.h"

#include <string>

namespace springdrive::limits {

inline constexpr double kTickPeriod_s = 1e-3;
inline constexpr double kPlate_m = 2e-3;
inline constexpr double kHalfPlate_m = 0.05;

[[nodiscard]] inline std::string plate_text() {
    return "a plate of " + with_unit(1e3 * kPlate_m, "mm");
}

/// Its upper side at y = 0.
[[nodiscard]] inline contact::TriangleSoup plate(double thickness_m) {
    return rig::solid_box({-kHalfPlate_m, -thickness_m, -kHalfPlate_m},
                          {kHalfPlate_m, 0.0, kHalfPlate_m});
}

/// Away from the diagonals and the middles of faces.
inline const Vector3 kAside_m(0.01, 0.0, 0.02);

[[nodiscard]] inline Vector3 at_height(double y_m) { return kAside_m + y_m * Vector3::UnitY(); }

} // namespace springdrive::limits
