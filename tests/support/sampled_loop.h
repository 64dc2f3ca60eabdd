// One motor under the sampled law (10) as scalars, for tests: verified by simulation in
// sampled_loop_test.cpp, and the reference for the loops of a whole device.
#pragma once

#include "device/core/device_description.h"
#include "device/core/motor/motor.h"
#include "device/core/phantom/dynamics.h"
#include "engine/control/velocity_filter.h"
#include "engine/lab/loops/linear_loop.h"
#include "engine/lab/loops/rendered_stiffness.h"

#include <Eigen/Core>

namespace springdrive::loops {

/// A motor that moves freely, except for its load and the hand on it:
///
///   L di/dt = e_W − dR i − k_T θ̇
///   (J_m + J_device + J_hand) θ̈ = k_T i − (b_device + b_hand) θ̇ − (k_device + k_hand) θ
///   e_W[k] = η k_T v[k] − (1 − η)(K_D v[k] + K_P θ[k]),   applied from (k + d) T to (k + d + 1) T
///
/// with η of the tuning: (10) under (17). A mode of the transpose map with eigenvalue a of α JᵀJ is
/// the loop with η = 1 − a.
struct SampledLoop {
    SpringDrive drive;
    device::RotorLoad device; ///< in addition to the rotor's inertia
    device::RotorLoad hand;   ///< zero: no hand
};

inline Eigen::MatrixXd one(double value) { return Eigen::MatrixXd::Constant(1, 1, value); }

/// Rotor, device and hand behind a spring drive: (11).
inline DrivenLoad driven_load(const SampledLoop &loop) {
    const device::MotorParameters &motor = loop.drive.motor;
    const double L = motor.inductance_H;
    const double k_T = motor.torque_constant_Nm_per_A;
    return {one(motor.rotor_inertia_kg_m2 + loop.device.inertia_kg_m2 + loop.hand.inertia_kg_m2),
            one(loop.device.damping_Nms_per_rad + loop.hand.damping_Nms_per_rad),
            one(loop.device.stiffness_Nm_per_rad + loop.hand.stiffness_Nm_per_rad),
            one(k_T),
            one(-loop.drive.dR_Ohm() / L),
            one(-k_T / L),
            one(1.0 / L)};
}

/// (10) under (17).
inline SampledLaw sampled_law(const SpringDrive &drive) {
    const control::Tuning &tuning = drive.tuning;
    const double held = 1.0 - tuning.eta;
    return {one(tuning.eta * drive.motor.torque_constant_Nm_per_A - held * tuning.K_D_Vs_per_rad),
            one(-held * tuning.K_P_V_per_rad),
            control::velocity_filter_pole(tuning.lambda_rad_per_s, drive.period_s), drive.period_s,
            drive.delay_periods};
}

/// The device's load on a joint's motor at the zero pose while all other joints are at rest:
/// M(0)/N² and the joint's viscous friction. Without the rotor.
/// @param joint  0, 1 or 2
inline device::RotorLoad device_load(const device::DeviceDescription &device, int joint) {
    const device::LinkageMoments moments =
        device::linkage_moments(device.geometry, device.inertia, device.inertia.tip_load_kg);
    const double N = device.geometry.transmission_ratio[joint];
    return {device::mass_matrix(moments, Vector3::Zero())(joint, joint) / (N * N),
            device.friction.viscous_Nms_per_rad / (N * N), 0.0};
}

inline Eigen::MatrixXd one_period_map(const SampledLoop &loop) {
    return one_period_map(
        sampled_load(driven_load(loop), loop.drive.period_s, loop.drive.delay_periods),
        sampled_law(loop.drive));
}

inline double largest_eigenvalue(const SampledLoop &loop) {
    return largest_eigenvalue(one_period_map(loop), sampled_law(loop.drive),
                              driven_load(loop).stiffness_Nm_per_rad);
}

/// True if every motion decays.
inline bool is_stable(const SampledLoop &loop) {
    return largest_eigenvalue(loop) < 1.0 - kEigenvalueRoundOff;
}

} // namespace springdrive::loops
