// What people perceive of a force, by the paper.
#pragma once

namespace springdrive::control {

// Both in its section V, which quotes them.

/// From here on people notice that a force's direction is wrong.
inline constexpr double kNoticeable_deg = 25.0;

/// Up to here they perceive forces by their hand's motion: the upper end of 20 to 30 Hz.
inline constexpr double kPerceived_Hz = 30.0;

} // namespace springdrive::control
