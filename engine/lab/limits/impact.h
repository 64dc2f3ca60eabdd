// What a hand feels where it meets a wall, and where there is none: measured on the simulated
// device.
#pragma once

#include "engine/lab/loops/stability_case.h"

namespace springdrive::limits {

/// A tip that comes down on a level wall.
struct Impact {
    /// Rate-hardness after Lawrence et al. 2000: how fast the force grows at first, over the speed
    /// of penetration. Here the steepest line from the moment of contact to the force of the motors
    /// along the normal 1 to 10 ms later, over the tip's speed at that moment; the mean over
    /// moments spread over a servo period [N/m]. Sooner than 1 ms no skin can tell.
    double rate_hardness_N_per_m = 0.0;
    double greatest_force_N = 0.0; ///< of the motors, within the same time
};

/// @param which     its hands: the first holds the tip
/// @param speed_m_per_s  at which the hand moves down
[[nodiscard]] Impact impact(const loops::StabilityCase &which, double speed_m_per_s = 0.1);

/// The tip's mass as the hand feels it in free space while it moves to and fro along the vertical
/// at 5 Hz: what of its force goes with the acceleration, without the hand's own mass, weight and
/// friction. [kg]
[[nodiscard]] double apparent_mass_kg(const loops::StabilityCase &which);

} // namespace springdrive::limits
