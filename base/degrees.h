// Angles are in radians internally; degrees are used only in input and output for people.
#pragma once

#include <numbers>

namespace springdrive {

inline constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;
inline constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

} // namespace springdrive
