// The stiffest virtual wall that a current drive renders stably: the baseline for the spring drive,
// tuned with the same care.
#pragma once

#include "engine/lab/loops/stability_case.h"

#include <cmath>

namespace springdrive::limits {

struct TunedWall {
    control::VirtualWall wall;
    double lambda_rad_per_s = 0.0; ///< of its velocity filter
};

/// The largest K, over all B and λ, for which every motor alone and all together are stable with
/// every hand, even with K and B larger by `margin`, and for which every motor comes to rest with
/// its counts and supply in trials with every hand. K is zero where nothing is stable.
/// @param which  its drive, wall, λ and freedom are ignored
/// @param max_count_N  maximum change of force from one count, see `force_of_a_count_N`
[[nodiscard]] TunedWall tuned_wall(loops::StabilityCase which, double margin,
                                   double max_count_N = HUGE_VAL);

} // namespace springdrive::limits
