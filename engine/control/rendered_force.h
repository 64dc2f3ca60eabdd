// Forces at the tip: how far their direction is from the surface normal (figures 5 and 6), from
// where people notice, and the virtual wall of a force-controlled device.
#pragma once

#include "base/vector.h"
#include "engine/contact/contact.h"
#include "engine/control/motion_control.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
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

/// A virtual wall as force-controlled devices render it, for the comparison with a current drive.
struct VirtualWall {
    double stiffness_N_per_m = 0.0;
    double damping_Ns_per_m = 0.0;
};

/// F = (1 − η) (K (x₀ − x) − B ẋ_f) on the tip [N]; zero where nothing is touched. A surface has a
/// normal: it pushes along that and never pulls.
[[nodiscard]] inline Vector3 wall_force_N(const VirtualWall &wall, const Configuration &now,
                                          const contact::Contact &contact, double eta) {
    if (!contact.touching) {
        return Vector3::Zero();
    }
    const Vector3 force_N = (1.0 - eta) * (wall.stiffness_N_per_m * (contact.x0_m - now.tip_m) -
                                           wall.damping_Ns_per_m * now.tip_velocity_m_per_s());
    return contact.normal.isZero() ? force_N
                                   : std::max(0.0, contact.normal.dot(force_N)) * contact.normal;
}

// Limits of human force perception, as quoted in section V of the paper.

/// From this angle on people notice an error in a force's direction.
inline constexpr double kNoticeable_deg = 25.0;

/// Up to this frequency they perceive forces kinaesthetically, by the motion of their hand: the
/// upper end of 20 to 30 Hz.
inline constexpr double kPerceived_Hz = 30.0;

} // namespace springdrive::control
