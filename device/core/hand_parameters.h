// The hand that holds the tip.
#pragma once

#include "base/vector.h"

namespace springdrive::device {

/// A hand that holds the tip: a mass, pulled towards a moving target by a spring and a damper. The
/// defaults are a relaxed pen grip, of the order of magnitude given in the literature on grips.
struct HandParameters {
    double mass_kg = 0.1;
    double damping_Ns_per_m = 6.0;
    double stiffness_N_per_m = 300.0;
    double max_force_N = 5.0;       ///< of the spring: a hand's force is limited
    double max_speed_m_per_s = 0.4; ///< of a target moved by `set_hand_target`
};

/// Where a hand's target is at a time; a path is a line through such points.
struct PathPoint {
    double time_s = 0.0;
    Vector3 position_m{Vector3::Zero()};
};

} // namespace springdrive::device
