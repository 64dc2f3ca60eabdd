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

/// JᵀJ: reflects a mass, damper or spring at the tip to the motors.
MatrixXd squared_levers(const StabilityCase &which, const LoopMember &member) {
    const Matrix3 J = jacobian(which);
    return picked(J.transpose() * J, moving(which, member));
}

double bandwidth_rad_per_s(const StabilityCase &which) {
    return 2.0 * std::numbers::pi * which.device.amplifier.current_bandwidth_hz;
}

} // namespace

StabilityCase motors_alone(const device::DeviceDescription &device, const control::Tuning &tuning) {
    StabilityCase which;
    which.device = device;
    which.tuning = tuning;
    which.tuning.map = control::MotionMap::inverse;
    which.q_rad.setZero();
    which.hands = {no_hand()};
    return which;
}

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
    DrivenLoad load = DrivenLoad::of(count);
    if (which.rotor) {
        load.inertia_kg_m2 = MatrixXd::Constant(1, 1, which.rotor->inertia_kg_m2);
        load.damping_Nms_per_rad = MatrixXd::Constant(1, 1, which.rotor->damping_Nms_per_rad);
        load.stiffness_Nm_per_rad = MatrixXd::Constant(1, 1, which.rotor->stiffness_Nm_per_rad);
    } else {
        const Linkage carried = linkage(which);
        load.inertia_kg_m2 = picked(carried.inertia_kg_m2, motors);
        load.damping_Nms_per_rad = picked(carried.damping_Nms_per_rad, motors);
    }
    load.inertia_kg_m2 += member.hand.mass_kg * hand_levers;
    load.damping_Nms_per_rad += member.hand.damping_Ns_per_m * hand_levers;
    load.stiffness_Nm_per_rad += member.hand.stiffness_N_per_m * hand_levers;

    for (Eigen::Index i = 0; i < count; ++i) {
        const device::MotorParameters &of = motor(which, motors[static_cast<std::size_t>(i)]);
        load.inertia_kg_m2(i, i) += which.rotor ? 0.0 : of.rotor_inertia_kg_m2;
        if (which.drive == device::AmplifierKind::spring_drive) {
            load.put_behind_spring_drive(i, of, which.dR_Ohm(of));
        } else {
            load.put_behind_current_drive(i, of, bandwidth_rad_per_s(which));
        }
    }
    return load;
}

SampledLaw sampled_law(const StabilityCase &which, const LoopMember &member) {
    const std::vector<int> motors = moving(which, member);
    VectorXd k_T(static_cast<Eigen::Index>(motors.size()));
    for (Eigen::Index i = 0; i < k_T.size(); ++i) {
        k_T[i] = motor(which, motors[static_cast<std::size_t>(i)]).torque_constant_Nm_per_A;
    }
    if (which.drive == device::AmplifierKind::current_drive) {
        const MatrixXd per_metre =
            (1.0 - which.tuning.eta) *
            MatrixXd(k_T.cwiseInverse().asDiagonal() * squared_levers(which, member));
        return {-which.wall.damping_Ns_per_m * per_metre, -which.wall.stiffness_N_per_m * per_metre,
                control::velocity_filter_pole(which.tuning.lambda_rad_per_s, which.period_s),
                which.period_s, which.delay_periods};
    }
    return drift_compensation(k_T, gains_of(which.tuning), held_share(which), which.sampling());
}

LinearLoop linear_loop(const StabilityCase &which, const LoopMember &member) {
    return {driven_load(which, member), which.sampling()};
}

double largest_eigenvalue(const StabilityCase &which, const LoopMember &member) {
    return linear_loop(which, member).largest_eigenvalue(sampled_law(which, member));
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
