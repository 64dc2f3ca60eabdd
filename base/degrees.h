// Angles are radians inside; degrees only where people read or write them.
#pragma once

#include <numbers>

namespace springdrive {

inline constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;
inline constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

} // namespace springdrive
