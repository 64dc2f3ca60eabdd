#include "engine/lab/loops/stability_case.h"

#include "device/core/phantom/dynamics.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"
#include "engine/control/velocity_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::loops {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The motors that move in a member's loop.
std::vector<int> moving(const StabilityCase &which, const LoopMember &member) {
    return which.freedom == Freedom::three_motors ? std::vector<int>{0, 1, 2}
                                                  : std::vector<int>{member.motor};
}

MatrixXd picked(const Matrix3 &whole, const std::vector<int> &motors) {
    return whole(motors, motors);
}

const device::MotorParameters &motor(const StabilityCase &which, int index) {
    return which.device.motor[static_cast<std::size_t>(index)];
}

/// J at the configuration.
Matrix3 jacobian(const StabilityCase &which) {
    return device::motor_jacobian(which.device.geometry, which.q_rad);
}

/// The linkage's inertia and friction through the transmission, without rotors and hand.
struct Linkage {
    Matrix3 inertia_kg_m2;
    Matrix3 damping_Nms_per_rad;
};

Linkage linkage(const StabilityCase &which) {
    const device::DeviceDescription &device = which.device;
    const device::LinkageMoments moments =
        device::linkage_moments(device.geometry, device.inertia, device.inertia.tip_load_kg);
    const Vector3 per_N = device.geometry.transmission_ratio.cwiseInverse();
    const Matrix3 scaled =
        per_N.asDiagonal() * device::mass_matrix(moments, which.q_rad) * per_N.asDiagonal();
    return {scaled,
            Matrix3((device.friction.viscous_Nms_per_rad * per_N.cwiseAbs2()).asDiagonal())};
}

/// JᵀJ: what a mass, damper or spring at the tip is at the motors.
MatrixXd squared_levers(const StabilityCase &which, const LoopMember &member) {
    const Matrix3 J = jacobian(which);
    return picked(J.transpose() * J, moving(which, member));
}

double bandwidth_rad_per_s(const StabilityCase &which) {
    return 2.0 * std::numbers::pi * which.device.amplifier.current_bandwidth_hz;
}

} // namespace

std::vector<LoopMember> members(const StabilityCase &which) {
    const bool each = which.freedom == Freedom::one_motor && !which.rotor;
    std::vector<LoopMember> all;
    for (const Hand &hand : which.hands) {
        for (const int motor : each ? std::vector<int>{0, 1, 2} : std::vector<int>{1}) {
            all.push_back({motor, hand});
        }
    }
    return all;
}

MatrixXd held_share(const StabilityCase &which) {
    const double held = 1.0 - which.tuning.eta;
    const bool one_motor = which.freedom == Freedom::one_motor;
    if (which.tuning.map == control::MotionMap::inverse) {
        const Eigen::Index n = one_motor ? 1 : 3;
        return held * MatrixXd::Identity(n, n);
    }
    const Matrix3 J = jacobian(which);
    const Vector3 W = control::relative_stiffness(which.device);
    const double bound = control::alpha_bound(J, W);
    const double alpha = which.tuning.alpha_mode == control::AlphaMode::by_hand
                             ? which.tuning.alpha_rad2_per_m2
                         : which.tuning.alpha_mode == control::AlphaMode::global
                             ? control::global_alpha_bound(which.device)
                             : bound;
    if (one_motor) {
        return MatrixXd::Constant(1, 1, held * alpha / bound);
    }
    return held * alpha * W.cwiseInverse().asDiagonal() * J.transpose() * J;
}

DrivenLoad driven_load(const StabilityCase &which, const LoopMember &member) {
    const std::vector<int> motors = moving(which, member);
    const auto count = static_cast<Eigen::Index>(motors.size());
    const MatrixXd hand_levers = squared_levers(which, member);
    DrivenLoad load;
    if (which.rotor) {
        load.inertia_kg_m2 = MatrixXd::Constant(1, 1, which.rotor->inertia_kg_m2);
        load.damping_Nms_per_rad = MatrixXd::Constant(1, 1, which.rotor->damping_Nms_per_rad);
        load.stiffness_Nm_per_rad = MatrixXd::Constant(1, 1, which.rotor->stiffness_Nm_per_rad);
    } else {
        const Linkage carried = linkage(which);
        load.inertia_kg_m2 = picked(carried.inertia_kg_m2, motors);
        load.damping_Nms_per_rad = picked(carried.damping_Nms_per_rad, motors);
        load.stiffness_Nm_per_rad = MatrixXd::Zero(count, count);
    }
    load.inertia_kg_m2 += member.hand.mass_kg * hand_levers;
    load.damping_Nms_per_rad += member.hand.damping_Ns_per_m * hand_levers;
    load.stiffness_Nm_per_rad += member.hand.stiffness_N_per_m * hand_levers;

    load.torque_Nm_per_A.resize(count);
    load.current_rate_per_current.resize(count);
    load.current_rate_per_velocity.resize(count);
    load.current_rate_per_command.resize(count);
    for (Eigen::Index i = 0; i < count; ++i) {
        const device::MotorParameters &of = motor(which, motors[static_cast<std::size_t>(i)]);
        const double L = of.inductance_H;
        const double k_T = of.torque_constant_Nm_per_A;
        load.inertia_kg_m2(i, i) += which.rotor ? 0.0 : of.rotor_inertia_kg_m2;
        load.torque_Nm_per_A[i] = k_T;
        const bool spring = which.drive == device::AmplifierKind::spring_drive;
        const double follows = bandwidth_rad_per_s(which);
        load.current_rate_per_current[i] = spring ? -which.dR_Ohm(of) / L : -follows;
        load.current_rate_per_velocity[i] = spring ? -k_T / L : 0.0;
        load.current_rate_per_command[i] = spring ? 1.0 / L : follows;
    }
    return load;
}

SampledLaw sampled_law(const StabilityCase &which, const LoopMember &member) {
    const std::vector<int> motors = moving(which, member);
    VectorXd k_T(static_cast<Eigen::Index>(motors.size()));
    for (Eigen::Index i = 0; i < k_T.size(); ++i) {
        k_T[i] = motor(which, motors[static_cast<std::size_t>(i)]).torque_constant_Nm_per_A;
    }
    SampledLaw law;
    law.filter_pole = control::velocity_filter_pole(which.tuning.lambda_rad_per_s, which.period_s);
    law.period_s = which.period_s;
    law.delay_periods = which.delay_periods;
    if (which.drive == device::AmplifierKind::current_drive) {
        const MatrixXd per_metre =
            (1.0 - which.tuning.eta) *
            MatrixXd(k_T.cwiseInverse().asDiagonal() * squared_levers(which, member));
        law.per_velocity = -which.wall.damping_Ns_per_m * per_metre;
        law.per_position = -which.wall.stiffness_N_per_m * per_metre;
        return law;
    }
    const MatrixXd A = held_share(which);
    const MatrixXd all = MatrixXd::Identity(A.rows(), A.cols());
    law.per_velocity = k_T.asDiagonal() * (all - A) - which.tuning.K_D_Vs_per_rad * A;
    law.per_position = -which.tuning.K_P_V_per_rad * A;
    return law;
}

double largest_eigenvalue(const StabilityCase &which, const LoopMember &member) {
    const DrivenLoad load = driven_load(which, member);
    const SampledLaw law = sampled_law(which, member);
    return largest_eigenvalue(
        one_period_map(sampled_load(load, which.period_s, which.delay_periods), law), law,
        load.stiffness_Nm_per_rad);
}

std::vector<WorstMember> ranked_members(const StabilityCase &which) {
    std::vector<WorstMember> ranked;
    for (const LoopMember &member : members(which)) {
        ranked.push_back({member, largest_eigenvalue(which, member)});
    }
    std::stable_sort(ranked.begin(), ranked.end(), [](const WorstMember &a, const WorstMember &b) {
        return a.eigenvalue > b.eigenvalue;
    });
    return ranked;
}

WorstMember worst_member(const StabilityCase &which) { return ranked_members(which).front(); }

bool is_stable(const StabilityCase &which) { return worst_member(which).is_stable(); }

} // namespace springdrive::loops
