#include "engine/control/haptic_law.h"

#include "device/core/phantom/kinematics.h"
#include "engine/control/drive_gains.h"
#include "engine/control/rendered_force.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace springdrive::control {

namespace {

double active_alpha(const Tuning &tuning, double bound, const AlphaSources &alpha) {
    switch (tuning.alpha_mode) {
    case AlphaMode::global:
        return alpha.global;
    case AlphaMode::by_hand:
        return tuning.alpha_rad2_per_m2;
    case AlphaMode::at_touch:
        return std::min(bound, alpha.before);
    case AlphaMode::on_the_fly:
        break;
    }
    return bound;
}

} // namespace

HapticLaw::HapticLaw(const device::DeviceDescription &device)
    : geometry_(device.geometry), motor_(device.motor), k_T_(torque_constants(device)),
      relative_stiffness_(relative_stiffness(device)), rad_per_count_(device.rad_per_count()) {}

Configuration HapticLaw::configuration(const Vector3 &theta_rad,
                                       const Vector3 &theta_rate_rad_per_s) const noexcept {
    const Vector3 q_rad = device::joint_from_motor(geometry_, theta_rad);
    return {theta_rad, theta_rate_rad_per_s, device::tip_position_m(geometry_, q_rad),
            device::motor_jacobian(geometry_, q_rad)};
}

LawOutcome HapticLaw::operator()(const Configuration &now, const contact::Contact &contact,
                                 const Tuning &tuning, const AlphaSources &alpha,
                                 const ObservedMotors &motors, double lag_s) const noexcept {
    LawOutcome found;
    found.eta = combined_eta(contact.eta, tuning.eta);
    found.alpha_bound_rad2_per_m2 = alpha_bound(now.J, relative_stiffness_);
    found.alpha_rad2_per_m2 = active_alpha(tuning, found.alpha_bound_rad2_per_m2, alpha);

    const TipSetPoint target =
        contact_set_point(now.tip_m, now.tip_velocity_m_per_s(), contact, found.eta);
    found.x_Sd_m = target.x_Sd_m;
    found.inverse = inverse_map(geometry_, now, target);
    found.transpose = transpose_map(now, target, found.alpha_rad2_per_m2, relative_stiffness_);
    found.used = tuning.map == MotionMap::transpose ? found.transpose
                                                    : found.inverse.value_or(no_force(now));

    double common_share = 1.0;
    Vector3 gain = k_T_.cwiseQuotient(torque_constants(motors));
    for (std::size_t j = 0; j < motor_.size(); ++j) {
        const auto index = static_cast<Eigen::Index>(j);
        double &dR_Ohm = found.dR_Ohm[index];
        dR_Ohm = acting_dR_Ohm(motor_[j], motors[j], tuning.dR_Ohm);
        gain[index] *= dR_Ohm / device::residual_resistance_Ohm(motor_[j], tuning.dR_Ohm);
        double &share = found.stiffness_share[index];
        share = allowed_stiffness_share(motor_[j], tuning, dR_Ohm, lag_s);
        common_share = std::min(common_share, 1.0 - motors[j].load * (1.0 - share));
        found.command.cancelled_resistance_Ohm[index] =
            cancelled_resistance_Ohm(motor_[j], motors[j], tuning.dR_Ohm);
    }
    found.stiffness_share = found.stiffness_share.cwiseMin(common_share);
    gain = gain.cwiseProduct(found.stiffness_share);
    found.command.e_W_V =
        drift_compensation_V(torque_constants(motors), tuning, now, found.used, gain);
    found.spring_A =
        tuning.K_P_V_per_rad *
        gain.cwiseProduct(found.used.theta_Sd_rad - now.theta_rad).cwiseQuotient(found.dR_Ohm);
    for (std::size_t j = 0; j < motor_.size(); ++j) {
        const auto index = static_cast<Eigen::Index>(j);
        const double spring_A = found.spring_A[index];
        found.trim_V[index] =
            std::copysign(1.0, spring_A) * used_trim_V(motor_[j], motors[j].trim_V, spring_A);
    }
    found.command.e_W_V += found.trim_V;
    return found;
}

Vector3 HapticLaw::force_direction(const Configuration &now,
                                   const MotorSetPoint &set_point) const noexcept {
    return static_tip_force(now.J, relative_stiffness_, set_point.theta_Sd_rad - now.theta_rad);
}

} // namespace springdrive::control
