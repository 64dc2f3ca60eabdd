#include "engine/lab/charts/motion_trial.h"

#include "base/eigenvalues.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/control/force_direction.h"
#include "engine/lab/loops/stability_case.h"

#include <cmath>
#include <cstddef>
#include <numbers>

namespace springdrive::charts {

namespace {

control::Configuration at_rest(const device::DeviceDescription &device, const Vector3 &theta_rad) {
    const Vector3 q_rad = device::joint_from_motor(device.geometry, theta_rad);
    return {theta_rad, Vector3::Zero(), device::tip_position_m(device.geometry, q_rad),
            device::motor_jacobian(device.geometry, q_rad)};
}

/// To the nearest count.
Vector3 quantised(const Vector3 &theta_rad, int counts_per_turn) {
    if (counts_per_turn == 0) {
        return theta_rad;
    }
    const double counts_per_rad = counts_per_turn / (2.0 * std::numbers::pi);
    return (counts_per_rad * theta_rad).array().round() / counts_per_rad;
}

/// The point of the wall nearest to the tip as the encoders show it.
Vector3 proxy_m(const Vector3 &true_tip_m, const Vector3 &estimated_tip_m, const HeldTip &tip) {
    const double height_m = tip.depth_m + tip.normal.dot(true_tip_m - estimated_tip_m);
    return estimated_tip_m + height_m * tip.normal;
}

/// The share of a displacement that each mode of the map opposes.
Vector3 mode_shares(const device::DeviceDescription &device, const MotionMethod &method,
                    const Matrix3 &J) {
    if (method.map == control::MotionMap::inverse) {
        return Vector3::Ones();
    }
    const Vector3 W = control::relative_stiffness(device);
    const double alpha = method.alpha_mode == control::AlphaMode::on_the_fly
                             ? control::alpha_bound(J, W)
                             : method.alpha_rad2_per_m2;
    // Symmetric, and similar to α W⁻¹ JᵀJ.
    const Matrix3 scaled = J * W.cwiseSqrt().cwiseInverse().asDiagonal();
    const Matrix3 modes = alpha * scaled.transpose() * scaled;
    return symmetric_eigenvalues(modes);
}

} // namespace

std::optional<control::MotorSetPoint> motor_set_point(const device::DeviceDescription &device,
                                                      const MotionMethod &method,
                                                      const control::Configuration &now,
                                                      const control::TipSetPoint &target) {
    if (method.map == control::MotionMap::inverse) {
        return control::inverse_map(device.geometry, now, target);
    }
    const Vector3 W = control::relative_stiffness(device);
    const double alpha = method.alpha_mode == control::AlphaMode::on_the_fly
                             ? control::alpha_bound(now.J, W)
                             : method.alpha_rad2_per_m2;
    return control::transpose_map(now, target, alpha, W);
}

Vector3 force_on_holder_N(const device::DeviceDescription &device, const control::Tuning &tuning,
                          const MotionMethod &method, const HeldTip &tip) {
    const control::Configuration truth =
        at_rest(device, device::motor_from_joint(device.geometry, tip.q_rad));
    const control::Configuration estimated =
        at_rest(device, quantised(truth.theta_rad, tip.counts_per_turn));
    contact::Contact contact;
    contact.x0_m = proxy_m(truth.tip_m, estimated.tip_m, tip);
    const control::TipSetPoint target =
        control::contact_set_point(estimated.tip_m, Vector3::Zero(), contact, tuning.eta);
    const std::optional<control::MotorSetPoint> set_point =
        motor_set_point(device, method, estimated, target);
    if (!set_point) {
        return Vector3::Zero();
    }
    return control::static_tip_force(truth.J,
                                     control::static_stiffness_Nm_per_rad(device.motor, tuning),
                                     set_point->theta_Sd_rad - estimated.theta_rad);
}

std::vector<Vector3> workspace_angles_rad(const device::DeviceDescription &device,
                                          int points_per_axis) {
    std::vector<Vector3> all;
    const auto share = [&](int i) { return (i + 0.5) / points_per_axis - 0.5; };
    for (int i = 0; i < points_per_axis; ++i) {
        for (int j = 0; j < points_per_axis; ++j) {
            for (int k = 0; k < points_per_axis; ++k) {
                const Vector3 tip_m =
                    device.workspace.centre_m +
                    device.workspace.size_m.cwiseProduct(Vector3(share(i), share(j), share(k)));
                if (device::can_reach(device, tip_m)) {
                    all.push_back(*device::joint_angles_rad(device.geometry, tip_m));
                }
            }
        }
    }
    return all;
}

std::vector<Vector3> spread_normals(int count) {
    std::vector<Vector3> normals;
    for (int i = 0; i < count; ++i) {
        const double height = 1.0 - (2.0 * i + 1.0) / count;
        const double angle_rad = 2.0 * std::numbers::pi * std::numbers::phi * i;
        const double across = std::sqrt(1.0 - height * height);
        normals.emplace_back(across * std::cos(angle_rad), height, across * std::sin(angle_rad));
    }
    return normals;
}

bool is_stable_at(const device::DeviceDescription &device, const control::Tuning &tuning,
                  const MotionMethod &method, const Vector3 &q_rad) {
    const Vector3 shares =
        mode_shares(device, method, device::motor_jacobian(device.geometry, q_rad));
    loops::StabilityCase each = loops::motors_alone(device, tuning);
    for (const double share : shares) {
        each.tuning.eta = 1.0 - (1.0 - tuning.eta) * share;
        if (!loops::is_stable(each)) {
            return false;
        }
    }
    return true;
}

} // namespace springdrive::charts
