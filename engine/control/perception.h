// Limits of human force perception, according to the paper.
#pragma once

namespace springdrive::control {

// Both are quoted in its section V.

/// From this angle on people notice an error in a force's direction.
inline constexpr double kNoticeable_deg = 25.0;

/// Up to this frequency they perceive forces kinaesthetically, by the motion of their hand: the
/// upper end of 20 to 30 Hz.
inline constexpr double kPerceived_Hz = 30.0;

} // namespace springdrive::control
