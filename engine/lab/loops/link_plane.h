// The plane of the links, for a device whose base joint is locked, as in figures 3, 5, 6 and 7.
//
// Its axes are outward (horizontal, from the base joint's axis towards the tip) and up. Its motors
// are those of q₂ and q₃.
#pragma once

#include "base/vector.h"
#include "device/core/phantom/kinematics.h"

#include <Eigen/Core>

#include <cmath>

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

} // namespace springdrive::loops
