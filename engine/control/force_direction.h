// The angle between a force and the surface normal (figures 5 and 6).
#pragma once

#include "base/vector.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <cmath>
#include <limits>

namespace springdrive::control {

/// Angle between a force and a surface normal [rad], 0 to π; NaN where either is zero. Exact for
/// small angles too, where an arc cosine would lose half its digits.
[[nodiscard]] inline double direction_error_rad(const Vector3 &force, const Vector3 &normal) {
    if (force.isZero(0.0) || normal.isZero(0.0)) {
        return std::numeric_limits<double>::quiet_NaN();
    }
    return std::atan2(force.cross(normal).norm(), force.dot(normal));
}

/// Static tip force (19), (22): F = J⁻ᵀ K_q (θ_Sd − θ). Its magnitude is in newtons when
/// `stiffness` is K_q's diagonal [N·m/rad]; with W only its direction is meaningful.
[[nodiscard]] inline Vector3 static_tip_force(const Matrix3 &J, const Vector3 &stiffness,
                                              const Vector3 &theta_gap_rad) {
    return J.transpose().inverse() * stiffness.cwiseProduct(theta_gap_rad);
}

} // namespace springdrive::control
