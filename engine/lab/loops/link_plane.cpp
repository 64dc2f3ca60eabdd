#include "engine/lab/loops/link_plane.h"

#include "base/input_error.h"
#include "engine/control/coupling.h"
#include "engine/control/motion_control.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>

namespace springdrive::loops {

namespace {

/// The links count as aligned when the tip's motions by the two motors are parallel up to an angle
/// with this sine: 0.006 degrees from the singular configuration.
constexpr double kMinSine = 1e-4;

/// (1 − η) K_DC (13) of the two motors that move the tip in the plane.
Vector2 motor_stiffness_at_rest_Nm_per_rad(const device::DeviceDescription &device,
                                           const control::Tuning &tuning) {
    return (1.0 - tuning.eta) *
           control::static_stiffness_Nm_per_rad(device.motor, tuning).tail<2>();
}

/// The bound (29) of α [rad²/m²] for the planar device, where the base column of J is zero.
double planar_alpha_bound_rad2_per_m2(const device::DeviceDescription &device,
                                      const Vector3 &q_rad) {
    Matrix3 J = device::motor_jacobian(device.geometry, q_rad);
    J.col(0).setZero();
    return control::alpha_bound(J, control::relative_stiffness(device));
}

/// The share A of a motion that the law treats as an error, see `drift_compensation`: I under the
/// inverse map, α W⁻¹ JᵀJ under the transpose map.
Matrix2 error_share(const PlanarContact &contact, control::MotionMap map) {
    if (map == control::MotionMap::inverse) {
        return Matrix2::Identity();
    }
    return contact.alpha_rad2_per_m2 * contact.relative_stiffness.cwiseInverse().asDiagonal() *
           contact.J.transpose() * contact.J;
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
    stiffness.K_q_Nm_per_rad = motor_stiffness_at_rest_Nm_per_rad(device, tuning);
    if (!(stiffness.K_q_Nm_per_rad.minCoeff() > 0.0)) {
        throw InputError("the tuning has no static stiffness, so no force results from a "
                         "displacement; choose K_P above 0 and eta below 1");
    }
    const Matrix2 J_inverse = J.inverse();
    stiffness.inverse = J_inverse.transpose() * stiffness.K_q_Nm_per_rad.asDiagonal() * J_inverse;
    stiffness.alpha_rad2_per_m2 = planar_alpha_bound_rad2_per_m2(device, q_rad);
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

PlanarContact planar_contact(const device::DeviceDescription &device, const control::Tuning &tuning,
                             const Vector3 &q_rad, double alpha_rad2_per_m2,
                             const Sampling &sampling) {
    PlanarContact contact;
    contact.J = planar_jacobian(device.geometry, q_rad);
    contact.alpha_rad2_per_m2 = alpha_rad2_per_m2;
    contact.relative_stiffness = control::relative_stiffness(device).tail<2>();
    for (std::size_t j = 0; j < 2; ++j) {
        contact.drive[j] = {device.motor[j + 1], tuning, sampling.period_s, sampling.delay_periods};
    }
    return contact;
}

Eigen::Matrix2cd motor_stiffness(const PlanarContact &contact, control::MotionMap map,
                                 double omega_rad_per_s) {
    DrivenLoad load = DrivenLoad::of(2);
    for (Eigen::Index j = 0; j < 2; ++j) {
        const SpringDrive &drive = contact.drive[static_cast<std::size_t>(j)];
        load.put_behind_spring_drive(j, drive.motor, drive.dR_Ohm());
    }
    const SpringDrive &servo = contact.drive[0];
    const SampledLaw law =
        drift_compensation(load.torque_Nm_per_A, gains_of(servo.tuning), error_share(contact, map),
                           {servo.period_s, servo.delay_periods});
    return motor_stiffness(load, law, omega_rad_per_s);
}

Eigen::Matrix2cd tip_stiffness(const PlanarContact &contact, control::MotionMap map,
                               double omega_rad_per_s) {
    const Eigen::Matrix2cd J_inverse = contact.J.inverse().cast<std::complex<double>>();
    return J_inverse.transpose() * motor_stiffness(contact, map, omega_rad_per_s) * J_inverse;
}

double phasor_direction_error_rad(const Eigen::Vector2cd &force, const Vector2 &normal) {
    // The ratio of F across n to F along n is exact for small angles, unlike an arc cosine.
    const std::complex<double> along = normal.x() * force.x() + normal.y() * force.y();
    const std::complex<double> across = normal.x() * force.y() - normal.y() * force.x();
    return std::atan2(std::abs(across), std::abs(along));
}

double worst_direction_error_rad(const Eigen::Matrix2cd &tip_stiffness) {
    constexpr int kNormals = 720; // in half a turn, as opposite normals have the same error
    double worst_rad = 0.0;
    for (int i = 0; i < kNormals; ++i) {
        const Vector2 n = direction_at(std::numbers::pi * i / kNormals);
        const Eigen::Vector2cd force = tip_stiffness * n.cast<std::complex<double>>();
        worst_rad = std::max(worst_rad, phasor_direction_error_rad(force, n));
    }
    return worst_rad;
}

} // namespace springdrive::loops
