// The plane of the links, for a device whose base joint is locked, as in figures 3, 5, 6 and 7, and
// the tip's stiffness in it: the ellipse of the inverse map and the circle of the transpose map
// (Fig. 3).
//
// The plane's axes are outward (horizontal, from the base joint's axis towards the tip) and up. Its
// motors are those of q₂ and q₃.
#pragma once

#include "device/core/device_description.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/tuning.h"

#include <Eigen/Core>

#include <cmath>
#include <vector>

namespace springdrive::loops {

using Vector2 = Eigen::Vector2d;
using Matrix2 = Eigen::Matrix2d;

/// Outward and up as columns, in the device frame.
[[nodiscard]] inline Eigen::Matrix<double, 3, 2> link_plane(double q1_rad) {
    Eigen::Matrix<double, 3, 2> axes;
    axes << std::sin(q1_rad), 0.0, //
        0.0, 1.0,                  //
        std::cos(q1_rad), 0.0;
    return axes;
}

/// J = ∂x/∂θ within the plane [m/rad]: rows outward and up, columns the motors of q₂ and q₃.
[[nodiscard]] inline Matrix2 planar_jacobian(const device::PhantomGeometry &geometry,
                                             const Vector3 &q_rad) {
    return link_plane(q_rad[0]).transpose() *
           device::motor_jacobian(geometry, q_rad).rightCols<2>();
}

/// The direction at an angle, counter-clockwise from outward to up.
[[nodiscard]] inline Vector2 direction_at(double angle_rad) {
    return {std::cos(angle_rad), std::sin(angle_rad)};
}

/// The angle from `from` to `to`, counter-clockwise, −π to π.
[[nodiscard]] inline double signed_angle_rad(const Vector2 &from, const Vector2 &to) {
    return std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
}

/// The stiffnesses of both maps for a device whose base is locked [N/m]: force per displacement.
struct PlanarStiffness {
    Matrix2 inverse;                  ///< (21), with K_q diagonal where motors differ
    Matrix2 transpose;                ///< (27): α k̄ I
    double alpha_rad2_per_m2 = 0.0;   ///< at the bound (29) of the planar device
    Vector2 K_q_Nm_per_rad{0.0, 0.0}; ///< diagonal of (20), for the motors of q₂ and q₃
};

/// At rest: K_q = (1 − η) K_DC of each motor (13), and α as large as (29) allows.
/// @throw InputError where the links are aligned, or where the tuning has no static stiffness.
[[nodiscard]] PlanarStiffness planar_stiffness(const device::DeviceDescription &device,
                                               const control::Tuning &tuning, const Vector3 &q_rad);

/// A displacement's direction and the forces that result.
struct EllipsePoint {
    double angle_rad = 0.0; ///< of the displacement
    Vector2 inverse_N_per_m{0.0, 0.0};
    Vector2 transpose_N_per_m{0.0, 0.0};
};

/// One full turn: K n for `points` unit vectors n, and the first once more. The semi-axes are the
/// eigenvalues of K.
[[nodiscard]] std::vector<EllipsePoint> stiffness_ellipses(const PlanarStiffness &stiffness,
                                                           int points);

/// The angle from a normal to the inverse map's force, for a small penetration along that normal.
[[nodiscard]] double inverse_direction_error_rad(const PlanarStiffness &stiffness,
                                                 double normal_rad);

} // namespace springdrive::loops
