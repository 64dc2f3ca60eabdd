// The dimensions of a PHANTOM that its kinematics need.
#pragma once

#include "base/vector.h"

namespace springdrive {

/// Link lengths and transmission; θ = N q, N diagonal. The values come from a device file.
struct PhantomGeometry {
    double upper_arm_m = 0.0;                    ///< l₁
    double forearm_m = 0.0;                      ///< l₂
    Vector3 transmission_ratio{Vector3::Ones()}; ///< diagonal of N, motor turns per joint turn
};

} // namespace springdrive
