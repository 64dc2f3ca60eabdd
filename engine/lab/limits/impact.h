// Rate-hardness of a wall and apparent mass in free space, measured on the simulated device.
#pragma once

#include "engine/lab/loops/stability_case.h"

namespace springdrive::limits {

/// A tip that moves down onto a level wall.
struct Impact {
    /// Rate-hardness after Lawrence et al. 2000: the initial rate of change of the force over the
    /// initial speed of penetration. Here the steepest line from the moment of contact to the force
    /// of the motors along the normal 1 to 10 ms later, over the tip's speed at that moment; the
    /// mean over contact times spread over a servo period [N/m]. The force is read every 20 µs, as
    /// between two ticks it may be larger than at either. The skin does not resolve times below
    /// 1 ms.
    double rate_hardness_N_per_m = 0.0;
    double max_force_N = 0.0; ///< of the motors, within the same time
};

/// @param which of its hands, the first holds the tip
/// @param speed_m_per_s  at which the hand moves down
[[nodiscard]] Impact impact(const loops::StabilityCase &which, double speed_m_per_s = 0.1);

/// The tip's apparent mass in free space while the hand moves it back and forth along the vertical
/// at 5 Hz: the part of the hand's force proportional to acceleration, without the hand's own mass,
/// weight and friction [kg].
[[nodiscard]] double apparent_mass_kg(const loops::StabilityCase &which);

} // namespace springdrive::limits
