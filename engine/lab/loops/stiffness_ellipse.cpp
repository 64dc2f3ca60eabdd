#include "engine/lab/loops/stiffness_ellipse.h"

#include "base/input_error.h"
#include "engine/control/coupling.h"
#include "engine/control/motion_control.h"

#include <Eigen/LU>

#include <cmath>
#include <cstddef>
#include <numbers>

namespace springdrive::loops {

namespace {

/// The links count as aligned when the tip's motions by the two motors are parallel up to an angle
/// with this sine: 0.006 degrees from the singular configuration.
constexpr double kMinSine = 1e-4;

/// (1 − η) K_DC (13) of the two motors that move the tip in its plane.
Vector2 planar_stiffness_Nm_per_rad(const device::DeviceDescription &device,
                                    const control::Tuning &tuning) {
    return (1.0 - tuning.eta) *
           control::static_stiffness_Nm_per_rad(device.motor, tuning).tail<2>();
}

/// (29) of the planar device: the base column of J is zero.
double planar_alpha_bound(const device::DeviceDescription &device, const Vector3 &q_rad) {
    Matrix3 J = device::motor_jacobian(device.geometry, q_rad);
    J.col(0).setZero();
    return control::alpha_bound(J, control::relative_stiffness(device));
}

} // namespace

PlanarStiffness planar_stiffness(const device::DeviceDescription &device,
                                 const control::Tuning &tuning, const Vector3 &q_rad) {
    const Matrix2 J = planar_jacobian(device.geometry, q_rad);
    if (!(std::abs(J.determinant()) > kMinSine * J.col(0).norm() * J.col(1).norm())) {
        throw InputError("the links are aligned at these joint angles, where the tip's stiffness "
                         "is unbounded; choose q3 - q2 farther from 90 and -90 degrees");
    }
    PlanarStiffness stiffness;
    stiffness.K_q_Nm_per_rad = planar_stiffness_Nm_per_rad(device, tuning);
    if (!(stiffness.K_q_Nm_per_rad.minCoeff() > 0.0)) {
        throw InputError("the tuning has no static stiffness, so no force results from a "
                         "displacement; choose K_P above 0 and eta below 1");
    }
    const Matrix2 J_inverse = J.inverse();
    stiffness.inverse = J_inverse.transpose() * stiffness.K_q_Nm_per_rad.asDiagonal() * J_inverse;
    stiffness.alpha_rad2_per_m2 = planar_alpha_bound(device, q_rad);
    stiffness.transpose = stiffness.alpha_rad2_per_m2 * (1.0 - tuning.eta) *
                          control::mean_static_stiffness_Nm_per_rad(device, tuning) *
                          Matrix2::Identity();
    return stiffness;
}

std::vector<EllipsePoint> stiffness_ellipses(const PlanarStiffness &stiffness, int points) {
    std::vector<EllipsePoint> around;
    for (int i = 0; i <= points; ++i) {
        const double angle_rad = 2.0 * std::numbers::pi * i / points;
        const Vector2 n = direction_at(angle_rad);
        around.push_back({angle_rad, stiffness.inverse * n, stiffness.transpose * n});
    }
    return around;
}

double inverse_direction_error_rad(const PlanarStiffness &stiffness, double normal_rad) {
    const Vector2 n = direction_at(normal_rad);
    return signed_angle_rad(n, stiffness.inverse * n);
}

} // namespace springdrive::loops
