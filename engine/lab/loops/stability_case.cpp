#include "engine/lab/loops/stability_case.h"

#include "device/core/phantom/dynamics.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"
#include "engine/control/velocity_filter.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
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

namespace {

device::RotorLoad rotor_of(const StabilityCase &which) {
    if (which.rotor) {
        return *which.rotor;
    }
    const DrivenLoad load = driven_load(which, {1, no_hand()});
    return {load.inertia_kg_m2(0, 0), load.damping_Nms_per_rad(0, 0),
            load.stiffness_Nm_per_rad(0, 0)};
}

/// A property of the hand belongs to one hand: the only one of the case, or a relaxed one.
Hand the_hand(const StabilityCase &which) {
    const bool one = which.hands.size() == 1;
    Hand hand = one ? which.hands.front() : hand_of_firmness(0.5);
    hand.name = "one hand";
    return hand;
}

template <double Hand::*member> double get_hand(const StabilityCase &which) {
    return the_hand(which).*member;
}

template <double Hand::*member> void set_hand(StabilityCase &which, double value) {
    Hand hand = the_hand(which);
    hand.*member = value;
    which.hands = {hand};
}

template <double control::Tuning::*member> double get_tuning(const StabilityCase &which) {
    return which.tuning.*member;
}

template <double control::Tuning::*member> void set_tuning(StabilityCase &which, double value) {
    which.tuning.*member = value;
}

using Case = StabilityCase;

const std::array<StabilityParameter, 15> kList{{
    {"kp", "K_P", "V/rad", 0.0, 1e4, 0.1, 200.0, true, get_tuning<&control::Tuning::K_P_V_per_rad>,
     set_tuning<&control::Tuning::K_P_V_per_rad>, "position gain (10)"},
    {"kd", "K_D", "V·s/rad", 0.0, 10.0, 1e-3, 1.0, true,
     get_tuning<&control::Tuning::K_D_Vs_per_rad>, set_tuning<&control::Tuning::K_D_Vs_per_rad>,
     "velocity gain (10)"},
    {"lambda", "λ", "rad/s", 1.0, 1e6, 10.0, 1e4, true,
     get_tuning<&control::Tuning::lambda_rad_per_s>, set_tuning<&control::Tuning::lambda_rad_per_s>,
     "cutoff of the velocity filter (12)"},
    {"dR", "dR", "Ω", -100.0, 100.0, 0.01, 2.18, true,
     [](const Case &c) { return c.dR_Ohm(c.device.motor[1]); },
     [](Case &c, double value) { c.net_resistance_Ohm = value; },
     "residual resistance (7); below 0 for a winding cooler than when tuned"},
    {"alpha", "α", "rad²/m²", 0.0, 1e7, 100.0, 1e5, true,
     get_tuning<&control::Tuning::alpha_rad2_per_m2>,
     [](Case &c, double value) {
         c.tuning.alpha_rad2_per_m2 = value;
         c.tuning.alpha_mode = control::AlphaMode::by_hand;
         c.tuning.map = control::MotionMap::transpose;
     },
     "scale of the transpose map (23), by hand"},
    {"T", "T", "s", 1e-6, 1.0, 1e-5, 0.05, true, [](const Case &c) { return c.period_s; },
     [](Case &c, double value) { c.period_s = value; }, "servo period"},
    {"d", "d", "periods", 0.0, 8.0, 0.0, 8.0, false, [](const Case &c) { return c.delay_periods; },
     [](Case &c, double value) { c.delay_periods = value; },
     "periods from reading θ to applying e_W, a real number"},
    {"eta", "η", "–", 0.0, 1.0, 0.0, 1.0, false, get_tuning<&control::Tuning::eta>,
     set_tuning<&control::Tuning::eta>, "0 rigid, 1 free space (30)"},
    {"hand-mass", "m of the hand", "kg", 0.0, 100.0, 1e-3, 10.0, true, get_hand<&Hand::mass_kg>,
     set_hand<&Hand::mass_kg>, "mass of one hand on the tip, instead of the six of the family"},
    {"hand-damping", "b of the hand", "N·s/m", 0.0, 1e4, 0.01, 100.0, true,
     get_hand<&Hand::damping_Ns_per_m>, set_hand<&Hand::damping_Ns_per_m>, "damping of one hand"},
    {"hand-stiffness", "k of the hand", "N/m", 0.0, 1e6, 1.0, 1e5, true,
     get_hand<&Hand::stiffness_N_per_m>, set_hand<&Hand::stiffness_N_per_m>,
     "stiffness of one hand"},
    {"inertia", "J", "kg·m²", 1e-12, 1e3, 1e-7, 1e-3, true,
     [](const Case &c) { return rotor_of(c).inertia_kg_m2; },
     [](Case &c, double value) {
         c.rotor = rotor_of(c);
         c.rotor->inertia_kg_m2 = value;
     },
     "inertia of one motor and all that it moves, at the motor"},
    {"damping", "b", "N·m·s/rad", 0.0, 1e3, 1e-8, 1e-2, true,
     [](const Case &c) { return rotor_of(c).damping_Nms_per_rad; },
     [](Case &c, double value) {
         c.rotor = rotor_of(c);
         c.rotor->damping_Nms_per_rad = value;
     },
     "damping of one motor and all that it moves, at the motor"},
    {"wall-stiffness", "K", "N/m", 0.0, 1e7, 1.0, 1e5, true,
     [](const Case &c) { return c.wall.stiffness_N_per_m; },
     [](Case &c, double value) { c.wall.stiffness_N_per_m = value; },
     "stiffness of a current drive's virtual wall, at the tip"},
    {"wall-damping", "B", "N·s/m", 0.0, 1e5, 0.1, 100.0, true,
     [](const Case &c) { return c.wall.damping_Ns_per_m; },
     [](Case &c, double value) { c.wall.damping_Ns_per_m = value; },
     "damping of a current drive's virtual wall, at the tip"},
}};

} // namespace

std::span<const StabilityParameter> stability_parameters() { return kList; }

const StabilityParameter *stability_parameter_named(std::string_view name) {
    const auto found = std::find_if(kList.begin(), kList.end(),
                                    [name](const auto &each) { return each.name == name; });
    return found == kList.end() ? nullptr : &*found;
}

std::string names_of_stability_parameters() {
    std::string names;
    for (const StabilityParameter &parameter : kList) {
        names += (names.empty() ? "" : ", ") + std::string(parameter.name);
    }
    return names;
}

std::string validate(const StabilityParameter &parameter, double value) {
    const bool in_range = value >= parameter.minimum && value <= parameter.maximum;
    const bool zero_dR = parameter.name == "dR" && value == 0.0;
    if (in_range && !zero_dR) {
        return {};
    }
    const bool has_unit = parameter.unit != "–";
    return fmt::format("{} is {:g}; it must be from {:g} to {:g}{}{}{}", parameter.name, value,
                       parameter.minimum, parameter.maximum, has_unit ? " " : "",
                       has_unit ? parameter.unit : "", zero_dR ? ", and not 0" : "");
}

} // namespace springdrive::loops
