#include "engine/lab/loops/both_maps.h"

#include "base/eigenvalues.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/control/haptic_law.h"
#include "engine/control/rendered_force.h"

#include <Eigen/LU>

#include <cmath>
#include <limits>

namespace springdrive::loops {

namespace {

/// Columns of J that span less than this share of the box that they could span.
constexpr double kFlatShare = 1e-3;

bool is_invertible(const Matrix3 &J) {
    const double box = J.col(0).norm() * J.col(1).norm() * J.col(2).norm();
    return std::abs(J.determinant()) > kFlatShare * box;
}

/// Calls `of(q)` at each place of the grid, which returns the value there, if there is one.
template <typename Of>
std::vector<WorkspaceValue> over_workspace(const device::DeviceDescription &device,
                                           double spacing_m, const Of &of) {
    const Eigen::Array3i steps = (0.5 * device.workspace.size_m / spacing_m).array().cast<int>();
    std::vector<WorkspaceValue> values;
    for (int x = -steps[0]; x <= steps[0]; ++x) {
        for (int y = -steps[1]; y <= steps[1]; ++y) {
            for (int z = -steps[2]; z <= steps[2]; ++z) {
                const Vector3 tip_m = device.workspace.centre_m + spacing_m * Vector3(x, y, z);
                const auto q_rad = device::joint_angles_rad(device.geometry, tip_m);
                if (!q_rad || !device.joint_limits.allow(*q_rad)) {
                    continue;
                }
                if (const std::optional<double> value = of(*q_rad);
                    value && std::isfinite(*value)) {
                    values.push_back({tip_m, *value});
                }
            }
        }
    }
    return values;
}

double alpha_at(const device::DeviceDescription &device, const Vector3 &q_rad) {
    return control::alpha_bound(device::motor_jacobian(device.geometry, q_rad),
                                control::relative_stiffness(device));
}

} // namespace

MapForces map_forces(const device::DeviceDescription &device, const control::Configuration &now,
                     const contact::Contact &contact, const control::Tuning &tuning,
                     double global_alpha_rad2_per_m2) {
    const control::HapticLaw law(device);
    const control::LawOutcome found = law(now, contact, tuning, {global_alpha_rad2_per_m2});
    const auto force_N = [&](const control::MotorSetPoint &set_point) {
        return control::static_tip_force(now.J, law.static_stiffness_Nm_per_rad(tuning),
                                         set_point.theta_Sd_rad - now.theta_rad);
    };
    MapForces forces;
    forces.transpose_N = force_N(found.transpose);
    if (found.inverse) {
        forces.inverse_N = force_N(*found.inverse);
    }
    return forces;
}

Matrix3 inverse_tip_stiffness(const device::DeviceDescription &device,
                              const control::Tuning &tuning, const Vector3 &q_rad) {
    const Vector3 K_q =
        (1.0 - tuning.eta) * control::static_stiffness_Nm_per_rad(device.motor, tuning);
    const Matrix3 J_inverse = device::motor_jacobian(device.geometry, q_rad).inverse();
    return J_inverse.transpose() * K_q.asDiagonal() * J_inverse;
}

std::optional<MapStiffness> map_stiffness(const device::DeviceDescription &device,
                                          const control::Tuning &tuning, const Vector3 &q_rad,
                                          double alpha_rad2_per_m2) {
    if (!is_invertible(device::motor_jacobian(device.geometry, q_rad))) {
        return std::nullopt;
    }
    return MapStiffness{inverse_tip_stiffness(device, tuning, q_rad),
                        (1.0 - tuning.eta) * alpha_rad2_per_m2 *
                            control::mean_static_stiffness_Nm_per_rad(device, tuning)};
}

double largest_error_rad(const Matrix3 &stiffness) {
    const Vector3 along_axes = symmetric_eigenvalues(stiffness);
    const double least = along_axes[0];
    const double most = along_axes[2];
    return least > 0.0 ? std::asin((most - least) / (most + least))
                       : std::numeric_limits<double>::quiet_NaN();
}

std::vector<WorkspaceValue> errors_in_workspace_rad(const device::DeviceDescription &device,
                                                    const control::Tuning &tuning,
                                                    double spacing_m) {
    return over_workspace(device, spacing_m, [&](const Vector3 &q_rad) -> std::optional<double> {
        const auto K = map_stiffness(device, tuning, q_rad, 0.0);
        return K ? std::optional(largest_error_rad(K->inverse_N_per_m)) : std::nullopt;
    });
}

std::vector<WorkspaceValue>
stiffnesses_in_workspace_N_per_m(const device::DeviceDescription &device,
                                 const control::Tuning &tuning, double spacing_m) {
    return over_workspace(device, spacing_m, [&](const Vector3 &q_rad) -> std::optional<double> {
        const auto K = map_stiffness(device, tuning, q_rad, alpha_at(device, q_rad));
        return K ? std::optional(K->transpose_N_per_m) : std::nullopt;
    });
}

} // namespace springdrive::loops
