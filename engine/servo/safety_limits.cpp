#include "engine/servo/safety_limits.h"

#include <algorithm>
#include <cmath>

namespace springdrive::servo {

SafetyLimits limits_of(const device::DeviceDescription &device) {
    SafetyLimits limits;
    for (const device::MotorParameters &motor : device.motor) {
        limits.voltage_V = std::max(limits.voltage_V, motor.supply_V);
        limits.current_A = std::max(limits.current_A, motor.peak_current_A);
        limits.winding_C = std::max(limits.winding_C, motor.thermal.max_winding_C);
    }
    limits.tip_force_N = device.limits.tip_force_N;
    limits.tip_speed_m_per_s = device.limits.tip_speed_m_per_s;
    limits.beyond_stops_rad = device.limits.beyond_stops_rad;
    limits.generated_energy_J = device.limits.generated_energy_J;
    limits.late_s = device.limits.late_s;
    limits.stale_s = device.limits.stale_s;
    limits.window_silence_s = device.limits.window_silence_s;
    return limits;
}

SafetyLimits lowered(const SafetyLimits &device, const SafetyLimits &request) noexcept {
    SafetyLimits limits = device;
    for (const SafetyLimit &limit : kSafetyLimits) {
        const double requested = request.*limit.value;
        if (requested > 0.0) { // false for NaN too
            limits.*limit.value = std::min(device.*limit.value, requested);
        }
    }
    return limits;
}

namespace {

double beyond(double value, double minimum, double maximum) {
    return value > maximum ? value - maximum : std::min(0.0, value - minimum);
}

/// The damper ramps up over this distance beyond the edge, to avoid a force step.
constexpr double kDamperWithin_rad = 0.02;

/// Only pushes back: the damper does not act against motion away from the edge.
double push_back(const device::WorkspaceEdge &edge, double beyond_rad, double rate_rad_per_s) {
    if (beyond_rad == 0.0) {
        return 0.0;
    }
    const double share = std::min(1.0, std::abs(beyond_rad) / kDamperWithin_rad);
    const double torque_Nm =
        -edge.stiffness_Nm_per_rad * beyond_rad - share * edge.damping_Nms_per_rad * rate_rad_per_s;
    return beyond_rad > 0.0 ? std::min(0.0, torque_Nm) : std::max(0.0, torque_Nm);
}

} // namespace

double BeyondLimits::max_excess_rad() const noexcept {
    return std::max(joint_rad.cwiseAbs().maxCoeff(), std::abs(fold_rad));
}

BeyondLimits beyond_limits(const device::JointLimits &limits, const Vector3 &q_rad,
                           double margin_rad) noexcept {
    BeyondLimits result;
    for (Eigen::Index j = 0; j < 3; ++j) {
        result.joint_rad[j] =
            beyond(q_rad[j], limits.min_rad[j] + margin_rad, limits.max_rad[j] - margin_rad);
    }
    result.fold_rad = beyond(q_rad[2] - q_rad[1], limits.min_q3_minus_q2_rad + margin_rad,
                             limits.max_q3_minus_q2_rad - margin_rad);
    return result;
}

Vector3 edge_torque_Nm(const device::DeviceDescription &device, const Vector3 &q_rad,
                       const Vector3 &q_rate_rad_per_s) noexcept {
    const device::WorkspaceEdge &edge = device.edge;
    const BeyondLimits over = beyond_limits(device.joint_limits, q_rad, edge.margin_rad);
    Vector3 torque_Nm;
    for (Eigen::Index j = 0; j < 3; ++j) {
        torque_Nm[j] = push_back(edge, over.joint_rad[j], q_rate_rad_per_s[j]);
    }
    const double fold_Nm =
        push_back(edge, over.fold_rad, q_rate_rad_per_s[2] - q_rate_rad_per_s[1]);
    torque_Nm[1] -= fold_Nm;
    torque_Nm[2] += fold_Nm;
    return torque_Nm;
}

} // namespace springdrive::servo
