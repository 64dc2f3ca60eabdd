#include "engine/servo/command_limiter.h"

#include "device/core/phantom/kinematics.h"
#include "engine/control/rendered_force.h"
#include "engine/servo/safety_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace springdrive::servo {

namespace {

const device::MotorParameters &motor_of(const device::DeviceDescription &device, Eigen::Index j) {
    return device.motor[static_cast<std::size_t>(j)];
}

/// R of a winding at this angle, at least: without observation, that of the worst angle.
double min_resistance_Ohm(const device::MotorParameters &file,
                          const control::ObservedMotor &motor) {
    constexpr double kDeviations = 2.0;
    const double without_ripple = 1.0 - file.commutation_ripple;
    const auto &[R_Ohm, deviation_Ohm] = motor.here;
    return motor.is_observed ? std::max(R_Ohm - kDeviations * deviation_Ohm, without_ripple * R_Ohm)
                             : without_ripple * file.resistance_Ohm;
}

/// The share of the steady currents that keeps force and currents within their limits.
struct Permissible {
    double share = 1.0;
    ForceLimit by = ForceLimit::none;

    void take(double other, ForceLimit limit) {
        if (other < share) {
            *this = {other, limit};
        }
    }
};

Permissible permissible(const device::DeviceDescription &device, const LimiterInputs &inputs,
                        const Vector3 &steady_current_A) {
    constexpr std::array<ForceLimit, 3> kCurrents{ForceLimit::current1, ForceLimit::current2,
                                                  ForceLimit::current3};
    Permissible result;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const double limit_A =
            kLimiterShare * std::min(motor_of(device, j).peak_current_A, inputs.limits.current_A);
        result.take(limit_A / std::abs(steady_current_A[j]), // infinite at zero current
                    kCurrents[static_cast<std::size_t>(j)]);
    }
    const double force_N =
        control::static_tip_force(inputs.now.J, control::torque_constants(inputs.motors),
                                  steady_current_A)
            .norm();
    if (!std::isfinite(force_N)) {
        return {0.0, ForceLimit::singular}; // the force is unknown
    }
    result.take(kLimiterShare * inputs.limits.tip_force_N / force_N, ForceLimit::tip_force);
    return result;
}

/// Moves e_W towards where no current flows as far as the limits of force and currents require.
/// Returns the remaining share.
Permissible draw_back(const device::DeviceDescription &device, const LimiterInputs &inputs,
                      const Vector3 &no_current_V, const Vector3 &dR_Ohm, Vector3 &e_W_V) {
    const Permissible result =
        permissible(device, inputs, (e_W_V - no_current_V).cwiseQuotient(dR_Ohm));
    if (result.share < 1.0) {
        e_W_V = no_current_V + result.share * (e_W_V - no_current_V);
    }
    return result;
}

/// Clamps e_W to the supply; returns whether that changed it.
bool hold_to_supply(const device::DeviceDescription &device, const LimiterInputs &inputs,
                    Vector3 &e_W_V) {
    const Vector3 before_V = e_W_V;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const double limit_V = std::min(motor_of(device, j).supply_V, inputs.limits.voltage_V);
        e_W_V[j] = std::clamp(e_W_V[j], -limit_V, limit_V);
    }
    return e_W_V != before_V;
}

} // namespace

LimitedCommand limited(const device::DeviceDescription &device,
                       const device::DeviceCommand &requested,
                       const LimiterInputs &inputs) noexcept {
    LimitedCommand result;
    const control::Configuration &now = inputs.now;
    const Vector3 edge_Nm =
        edge_torque_Nm(device, device::joint_from_motor(device.geometry, now.theta_rad),
                       device::joint_from_motor(device.geometry, now.theta_rate_rad_per_s));
    result.active_limits.at_edge = !edge_Nm.isZero(0.0);

    Vector3 no_current_V; // back-EMF and trim, less what R̂ makes of the sensor's offset
    Vector3 dR_Ohm;
    Vector3 e_W_V;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const device::MotorParameters &file = motor_of(device, j);
        const control::ObservedMotor &motor = inputs.motors[static_cast<std::size_t>(j)];
        const double R_hat_Ohm = std::clamp(inputs.ramp * requested.cancelled_resistance_Ohm[j],
                                            0.0, inputs.R_hat_limit_Ohm[j]);
        result.command.cancelled_resistance_Ohm[j] = R_hat_Ohm;
        dR_Ohm[j] = std::max(min_resistance_Ohm(file, motor) - R_hat_Ohm,
                             device::kMinResidualShare * file.resistance_Ohm);
        const double offset_V = R_hat_Ohm * motor.offset_A;
        no_current_V[j] = motor.torque_constant_Nm_per_A * now.theta_rate_rad_per_s[j] +
                          inputs.ramp * inputs.trim_V[j] - offset_V;
        const double edge_A =
            edge_Nm[j] / (device.geometry.transmission_ratio[j] * motor.torque_constant_Nm_per_A);
        e_W_V[j] = inputs.ramp * (requested.e_W_V[j] + dR_Ohm[j] * edge_A) - offset_V;
    }
    const Permissible first = draw_back(device, inputs, no_current_V, dR_Ohm, e_W_V);
    result.force_share = first.share;
    result.active_limits.force = first.by;
    result.permissible_e_W_V = e_W_V;
    result.active_limits.voltage = hold_to_supply(device, inputs, e_W_V);
    if (result.active_limits.voltage) { // the clamped part may have opposed the others: check again
        const Permissible second = draw_back(device, inputs, no_current_V, dR_Ohm, e_W_V);
        result.force_share *= second.share;
        result.active_limits.force = second.share < 1.0 ? second.by : first.by;
        static_cast<void>(hold_to_supply(device, inputs, e_W_V));
    }
    result.command.e_W_V = e_W_V;
    return result;
}

} // namespace springdrive::servo
