#include "engine/analysis/sampled_loop.h"

#include "device/phantom/dynamics.h"
#include "engine/control/velocity_filter.h"

#include <Eigen/Eigenvalues>
#include <unsupported/Eigen/MatrixFunctions>

namespace springdrive {

namespace {

/// Where each state stands.
enum State : Eigen::Index { theta, moved, rate, current, velocity, first_held };

/// What is left of 1 − |λ| by round-off where a mode neither grows nor dies.
constexpr double kRoundOff = 1e-10;

RotorLoad all_that_moves(const SampledLoop &loop) {
    return {loop.drive.motor.rotor_inertia_kg_m2 + loop.device.inertia_kg_m2 +
                loop.hand.inertia_kg_m2,
            loop.device.damping_Nms_per_rad + loop.hand.damping_Nms_per_rad,
            loop.device.stiffness_Nm_per_rad + loop.hand.stiffness_Nm_per_rad};
}

/// [θ, θ̇, i, e_W] after a period from the same before it, e_W standing still.
Eigen::Matrix4d plant_over_a_period(const SampledLoop &loop) {
    const MotorParameters &motor = loop.drive.motor;
    const RotorLoad load = all_that_moves(loop);
    const double k_T = motor.torque_constant_Nm_per_A;
    Eigen::Matrix4d rates = Eigen::Matrix4d::Zero();
    rates(0, 1) = 1.0;
    rates.row(1) << -load.stiffness_Nm_per_rad, -load.damping_Nms_per_rad, k_T, 0.0;
    rates.row(1) /= load.inertia_kg_m2;
    rates.row(2) << 0.0, -k_T, -loop.drive.dR_Ohm(), 1.0;
    rates.row(2) /= motor.inductance_H;
    return (rates * loop.drive.period_s).exp();
}

/// v[k] of the states at sample k.
Eigen::RowVectorXd filtered_velocity(const SpringDrive &drive, Eigen::Index states) {
    const double a = velocity_filter_pole(drive.tuning.lambda_rad_per_s, drive.period_s);
    Eigen::RowVectorXd v = Eigen::RowVectorXd::Zero(states);
    v[velocity] = a;
    v[moved] = (1.0 - a) / drive.period_s;
    return v;
}

/// e_W[k] of the states at sample k: (10) under (17).
Eigen::RowVectorXd voltage(const SpringDrive &drive, const Eigen::RowVectorXd &v) {
    const Tuning &tuning = drive.tuning;
    const double held = 1.0 - tuning.eta;
    Eigen::RowVectorXd e =
        (tuning.eta * drive.motor.torque_constant_Nm_per_A - held * tuning.K_D_Vs_per_rad) * v;
    e[theta] -= held * tuning.K_P_V_per_rad;
    return e;
}

bool may_rest_anywhere(const SampledLoop &loop) {
    const Tuning &tuning = loop.drive.tuning;
    return (1.0 - tuning.eta) * tuning.K_P_V_per_rad == 0.0 &&
           all_that_moves(loop).stiffness_Nm_per_rad == 0.0;
}

} // namespace

RotorLoad device_load(const DeviceDescription &device, int joint) {
    const LinkageMoments moments =
        linkage_moments(device.geometry, device.inertia, device.inertia.tip_load_kg);
    const double N = device.geometry.transmission_ratio[joint];
    return {mass_matrix(moments, Vector3::Zero())(joint, joint) / (N * N),
            device.friction.viscous_Nms_per_rad / (N * N), 0.0};
}

Eigen::MatrixXd one_period_map(const SampledLoop &loop) {
    const Eigen::Index held = loop.drive.delay_samples;
    const Eigen::Index states = first_held + held;
    const Eigen::RowVectorXd v = filtered_velocity(loop.drive, states);
    const Eigen::RowVectorXd e = voltage(loop.drive, v);
    const Eigen::RowVectorXd applied =
        held == 0 ? e : Eigen::RowVectorXd(Eigen::RowVectorXd::Unit(states, states - 1));

    const Eigen::Matrix4d plant = plant_over_a_period(loop);
    Eigen::MatrixXd before = Eigen::MatrixXd::Zero(4, states); // [θ, θ̇, i, e_W] of the states
    before(0, theta) = 1.0;
    before(1, rate) = 1.0;
    before(2, current) = 1.0;
    before.row(3) = applied;
    const Eigen::MatrixXd after = plant.topRows<3>() * before;

    Eigen::MatrixXd map = Eigen::MatrixXd::Zero(states, states);
    map.row(theta) = after.row(0);
    map.row(moved) = after.row(0) - before.row(0);
    map.row(rate) = after.row(1);
    map.row(current) = after.row(2);
    map.row(velocity) = v;
    if (held > 0) {
        map.row(first_held) = e;
        map.block(first_held + 1, first_held, held - 1, held - 1).setIdentity();
    }
    return map;
}

double largest_eigenvalue(const SampledLoop &loop) {
    Eigen::MatrixXd map = one_period_map(loop);
    if (may_rest_anywhere(loop)) {
        const Eigen::Index rest = map.rows() - 1;
        map = Eigen::MatrixXd(map.bottomRightCorner(rest, rest));
    }
    return map.eigenvalues().cwiseAbs().maxCoeff();
}

bool is_stable(const SampledLoop &loop) { return largest_eigenvalue(loop) < 1.0 - kRoundOff; }

} // namespace springdrive
