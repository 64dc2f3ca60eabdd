#include "engine/lab/loops/direction_spectrum.h"

#include "engine/control/motion_control.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>

namespace springdrive::loops {

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
    const Matrix2 A = map == control::MotionMap::inverse
                          ? Matrix2(Matrix2::Identity())
                          : Matrix2(contact.alpha_rad2_per_m2 *
                                    contact.relative_stiffness.cwiseInverse().asDiagonal() *
                                    contact.J.transpose() * contact.J);
    const SpringDrive &servo = contact.drive[0];
    const SampledLaw law = drift_compensation(load.torque_Nm_per_A, gains_of(servo.tuning), A,
                                              {servo.period_s, servo.delay_periods});
    return motor_stiffness(load, law, omega_rad_per_s);
}

Eigen::Matrix2cd tip_stiffness(const PlanarContact &contact, control::MotionMap map,
                               double omega_rad_per_s) {
    const Eigen::Matrix2cd J_inverse = contact.J.inverse().cast<std::complex<double>>();
    return J_inverse.transpose() * motor_stiffness(contact, map, omega_rad_per_s) * J_inverse;
}

double phasor_direction_error_rad(const Eigen::Vector2cd &force, const Vector2 &normal) {
    // From the parts of F across and along n: exact for small angles, unlike an arc cosine.
    const std::complex<double> along = normal.x() * force.x() + normal.y() * force.y();
    const std::complex<double> across = normal.x() * force.y() - normal.y() * force.x();
    return std::atan2(std::abs(across), std::abs(along));
}

double worst_direction_error_rad(const Eigen::Matrix2cd &tip_stiffness) {
    constexpr int kNormals = 720; // over half a turn: opposite normals have the same error
    double worst = 0.0;
    for (int i = 0; i < kNormals; ++i) {
        const Vector2 n = direction_at(std::numbers::pi * i / kNormals);
        const Eigen::Vector2cd force = tip_stiffness * n.cast<std::complex<double>>();
        worst = std::max(worst, phasor_direction_error_rad(force, n));
    }
    return worst;
}

} // namespace springdrive::loops
