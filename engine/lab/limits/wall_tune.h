// The stiffest virtual wall that a current drive renders stably: the baseline that the spring drive
// is held against, tuned with the same care.
#pragma once

#include "engine/lab/loops/stability_case.h"

#include <cmath>

namespace springdrive::limits {

struct TunedWall {
    control::VirtualWall wall;
    double lambda_rad_per_s = 0.0; ///< of its velocity filter
};

/// The largest K, over all B and λ, for which every motor by itself and all together are stable
/// with every hand, even with K and B larger by `margin`, and for which every motor comes to rest
/// on its counts and supply in trials with every hand. K is zero where nothing is stable.
/// @param which  its drive, wall, λ and freedom do not matter
/// @param greatest_count_N  what a count may do to the force, see `force_of_a_count_N`
[[nodiscard]] TunedWall tuned_wall(loops::StabilityCase which, double margin,
                                   double greatest_count_N = HUGE_VAL);

} // namespace springdrive::limits
