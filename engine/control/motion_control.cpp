#include "engine/control/motion_control.h"

#include "base/eigenvalues.h"
#include "device/core/phantom/kinematics.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace springdrive::control {

namespace {

/// Below this |det J|, relative to the product of its columns' lengths, the linkage counts as
/// singular: it would amplify round-off in a set-point rate a million times.
constexpr double kSingularDeterminant = 1e-6;

[[nodiscard]] bool is_singular(const Matrix3 &J) {
    const double scale = J.col(0).norm() * J.col(1).norm() * J.col(2).norm();
    return !(std::abs(J.determinant()) > kSingularDeterminant * scale);
}

} // namespace

TipSetPoint contact_set_point(const Vector3 &tip_m, const Vector3 &tip_velocity_m_per_s,
                              const contact::Contact &contact, double eta) {
    TipSetPoint target;
    target.x_Sd_m = eta * tip_m + (1.0 - eta) * contact.x0_m;
    target.x_Sd_rate_m_per_s = eta * tip_velocity_m_per_s +
                               (1.0 - eta) * (contact.tangent_projector * tip_velocity_m_per_s);
    return target;
}

std::optional<MotorSetPoint> inverse_map(const device::PhantomGeometry &geometry,
                                         const Configuration &configuration,
                                         const TipSetPoint &target) {
    const std::optional<Vector3> q_Sd_rad = device::joint_angles_rad(geometry, target.x_Sd_m);
    if (!q_Sd_rad || is_singular(configuration.J)) {
        return std::nullopt;
    }
    return MotorSetPoint{device::motor_from_joint(geometry, *q_Sd_rad),
                         configuration.J.inverse() * target.x_Sd_rate_m_per_s};
}

MotorSetPoint transpose_map(const Configuration &configuration, const TipSetPoint &target,
                            double alpha_rad2_per_m2, const Vector3 &relative_stiffness) {
    const Matrix3 map = alpha_rad2_per_m2 * relative_stiffness.cwiseInverse().asDiagonal() *
                        configuration.J.transpose();
    const Vector3 rate_gap = target.x_Sd_rate_m_per_s - configuration.tip_velocity_m_per_s();
    return {configuration.theta_rad + map * (target.x_Sd_m - configuration.tip_m),
            configuration.theta_rate_rad_per_s + map * rate_gap};
}

double alpha_bound(const Matrix3 &J, const Vector3 &relative_stiffness) {
    const Matrix3 compliance = J * relative_stiffness.cwiseInverse().asDiagonal() * J.transpose();
    return 1.0 / symmetric_eigenvalues(compliance)[2];
}

double global_alpha_bound(const device::DeviceDescription &device, int points_per_axis) {
    const Vector3 weights = relative_stiffness(device);
    const double step = 1.0 / std::max(1, points_per_axis - 1);
    double minimum = std::numeric_limits<double>::infinity();
    for (int i = 0; i < points_per_axis; ++i) {
        for (int j = 0; j < points_per_axis; ++j) {
            for (int k = 0; k < points_per_axis; ++k) {
                const Vector3 fraction(i * step - 0.5, j * step - 0.5, k * step - 0.5);
                const Vector3 point_m =
                    device.workspace.centre_m + fraction.cwiseProduct(device.workspace.size_m);
                const std::optional<Vector3> q_rad =
                    device::joint_angles_rad(device.geometry, point_m);
                if (q_rad) {
                    minimum = std::min(
                        minimum,
                        alpha_bound(device::motor_jacobian(device.geometry, *q_rad), weights));
                }
            }
        }
    }
    return std::isfinite(minimum) ? minimum : 0.0;
}

Vector3 drift_compensation_V(const Vector3 &k_T, const Tuning &tuning,
                             const Configuration &configuration, const MotorSetPoint &set_point,
                             const Vector3 &gain) {
    const Vector3 rate_error =
        set_point.theta_Sd_rate_rad_per_s - configuration.theta_rate_rad_per_s;
    return k_T.cwiseProduct(set_point.theta_Sd_rate_rad_per_s) +
           gain.cwiseProduct(tuning.K_D_Vs_per_rad * rate_error) +
           gain.cwiseProduct(tuning.K_P_V_per_rad *
                             (set_point.theta_Sd_rad - configuration.theta_rad));
}

Vector3 torque_constants(const device::DeviceDescription &device) {
    return {device.motor[0].torque_constant_Nm_per_A, device.motor[1].torque_constant_Nm_per_A,
            device.motor[2].torque_constant_Nm_per_A};
}

Vector3 relative_stiffness(const device::DeviceDescription &device) {
    const Vector3 k_T = torque_constants(device);
    return k_T / k_T.mean();
}

} // namespace springdrive::control
