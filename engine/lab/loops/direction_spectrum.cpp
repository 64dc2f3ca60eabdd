#include "engine/lab/loops/direction_spectrum.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>

namespace springdrive::loops {

namespace {

/// K_free: what is felt of a motor whose set-point goes with it (16), the lag of its filter.
std::complex<double> free_stiffness(SpringDrive drive, double omega_rad_per_s) {
    drive.tuning.K_P_V_per_rad = 0.0;
    drive.tuning.K_D_Vs_per_rad = -drive.motor.torque_constant_Nm_per_A;
    return sampled_stiffness(drive, omega_rad_per_s);
}

} // namespace

Eigen::Matrix2cd motor_stiffness(const PlanarContact &contact, control::MotionMap map,
                                 double omega_rad_per_s) {
    Eigen::Vector2cd held;
    Eigen::Vector2cd free;
    for (Eigen::Index j = 0; j < 2; ++j) {
        const SpringDrive &drive = contact.drive[static_cast<std::size_t>(j)];
        held[j] = sampled_stiffness(drive, omega_rad_per_s);
        free[j] = free_stiffness(drive, omega_rad_per_s);
    }
    if (map == control::MotionMap::inverse) {
        return held.asDiagonal();
    }
    const Matrix2 A = contact.alpha_rad2_per_m2 *
                      contact.relative_stiffness.cwiseInverse().asDiagonal() *
                      contact.J.transpose() * contact.J;
    const Matrix2 rest = Matrix2::Identity() - A;
    return held.asDiagonal() * A.cast<std::complex<double>>() +
           free.asDiagonal() * rest.cast<std::complex<double>>();
}

Eigen::Matrix2cd tip_stiffness(const PlanarContact &contact, control::MotionMap map,
                               double omega_rad_per_s) {
    const Eigen::Matrix2cd J_inverse = contact.J.inverse().cast<std::complex<double>>();
    return J_inverse.transpose() * motor_stiffness(contact, map, omega_rad_per_s) * J_inverse;
}

double phasor_direction_error_rad(const Eigen::Vector2cd &force, const Vector2 &normal) {
    // The rest of F beside its part along n: exact for small angles, where an arc cosine is not.
    const std::complex<double> along = normal.x() * force.x() + normal.y() * force.y();
    const std::complex<double> across = normal.x() * force.y() - normal.y() * force.x();
    return std::atan2(std::abs(across), std::abs(along));
}

double worst_direction_error_rad(const Eigen::Matrix2cd &tip_stiffness) {
    constexpr int kNormals = 720; // over half a turn: a normal and its opposite err alike
    double worst = 0.0;
    for (int i = 0; i < kNormals; ++i) {
        const Vector2 n = direction_at(std::numbers::pi * i / kNormals);
        const Eigen::Vector2cd force = tip_stiffness * n.cast<std::complex<double>>();
        worst = std::max(worst, phasor_direction_error_rad(force, n));
    }
    return worst;
}

} // namespace springdrive::loops
