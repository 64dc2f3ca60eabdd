#include "engine/lab/loops/stability_case.h"

#include "device/core/phantom/dynamics.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"
#include "engine/control/velocity_filter.h"

#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

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

Linkage linkage(const StabilityCase &which, double tip_load_kg) {
    const device::DeviceDescription &device = which.device;
    const device::LinkageMoments moments =
        device::linkage_moments(device.geometry, device.inertia, tip_load_kg);
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

/// What moves between the rotors and the ground: linkage, hand and structure, in the coordinates of
/// `driven_load`. Entries are added to blocks, one block for each kind of coordinate.
class Bodies {
public:
    Bodies(DrivenLoad &load, Eigen::Index motors) : load_(load), motors_(motors) {}

    void add(Eigen::Index block, const MatrixXd &inertia, const MatrixXd &damping,
             const MatrixXd &stiffness) {
        at(load_.inertia_kg_m2, block, block) += inertia;
        at(load_.damping_Nms_per_rad, block, block) += damping;
        at(load_.stiffness_Nm_per_rad, block, block) += stiffness;
    }

    /// A spring and a damper between two blocks, for each coordinate of the second one.
    /// @param levers  its motion per motion of the first
    void tie(Eigen::Index first, Eigen::Index second, const MatrixXd &levers,
             const VectorXd &stiffness, const VectorXd &damping) {
        for (const auto &[matrix, of] : {std::pair(&load_.stiffness_Nm_per_rad, &stiffness),
                                         std::pair(&load_.damping_Nms_per_rad, &damping)}) {
            const MatrixXd K = of->asDiagonal();
            at(*matrix, first, first) += levers.transpose() * K * levers;
            at(*matrix, first, second) -= levers.transpose() * K;
            at(*matrix, second, first) -= K * levers;
            at(*matrix, second, second) += K;
        }
    }

private:
    [[nodiscard]] Eigen::Block<MatrixXd> at(MatrixXd &matrix, Eigen::Index row,
                                            Eigen::Index column) const {
        return matrix.block(row * motors_, column * motors_, motors_, motors_);
    }

    DrivenLoad &load_;
    Eigen::Index motors_;
};

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
    const std::vector<Structure> rigid{Structure{}};
    std::vector<LoopMember> all;
    for (const Structure &structure : which.rotor ? rigid : which.structures) {
        for (const Hand &hand : which.hands) {
            for (const int motor : each ? std::vector<int>{0, 1, 2} : std::vector<int>{1}) {
                all.push_back({motor, hand, structure});
            }
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
    const Structure gives = which.rotor ? Structure{} : member.structure;
    const double in_cable = gives.in_cable();
    const double tip_kg = member.hand.mass_kg + which.device.inertia.tip_load_kg;
    const double at_tip = tip_kg > 0.0 ? gives.at_tip() : 0.0;
    const Eigen::Index linkage_block = in_cable > 0.0 ? 1 : 0;
    const Eigen::Index tip_block = linkage_block + (at_tip > 0.0 ? 1 : 0);
    DrivenLoad load = DrivenLoad::of(count, count * (tip_block + 1));
    Bodies bodies(load, count);

    const Hand &hand = member.hand;
    const MatrixXd hand_levers = squared_levers(which, member);
    if (which.rotor) {
        bodies.add(0, MatrixXd::Constant(1, 1, which.rotor->inertia_kg_m2),
                   MatrixXd::Constant(1, 1, which.rotor->damping_Nms_per_rad),
                   MatrixXd::Constant(1, 1, which.rotor->stiffness_Nm_per_rad));
    } else {
        const Linkage carried =
            linkage(which, at_tip > 0.0 ? 0.0 : which.device.inertia.tip_load_kg);
        bodies.add(linkage_block, picked(carried.inertia_kg_m2, motors),
                   picked(carried.damping_Nms_per_rad, motors), MatrixXd::Zero(count, count));
    }
    if (in_cable > 0.0) {
        const std::array<device::CableCompliance, 3> cables =
            device::cable_compliance(which.device, in_cable);
        VectorXd stiffness(count);
        VectorXd damping(count);
        for (Eigen::Index i = 0; i < count; ++i) {
            const device::CableCompliance &cable =
                cables[static_cast<std::size_t>(motors[static_cast<std::size_t>(i)])];
            stiffness[i] = cable.stiffness_Nm_per_rad;
            damping[i] = cable.damping_Nms_per_rad;
        }
        bodies.tie(0, linkage_block, MatrixXd::Identity(count, count), stiffness, damping);
    }
    if (at_tip > 0.0) {
        const MatrixXd all = MatrixXd::Identity(count, count);
        bodies.add(tip_block, tip_kg * all, hand.damping_Ns_per_m * all,
                   hand.stiffness_N_per_m * all);
        const MatrixXd levers =
            count == 1 ? MatrixXd(hand_levers.cwiseSqrt()) : MatrixXd(jacobian(which));
        const device::StructuralCompliance tip =
            device::tip_compliance(which.device.structure, 1.0 - at_tip);
        bodies.tie(linkage_block, tip_block, levers,
                   VectorXd::Constant(count, tip.stiffness_N_per_m),
                   VectorXd::Constant(count, tip.damping_Ns_per_m));
    } else {
        bodies.add(linkage_block, hand.mass_kg * hand_levers, hand.damping_Ns_per_m * hand_levers,
                   hand.stiffness_N_per_m * hand_levers);
    }

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

std::string structure_text(const Structure &structure) {
    if (!structure.cable_share) {
        return "rigid links";
    }
    return structure.in_cable() == 0.0 ? "compliant tip"
           : structure.at_tip() == 0.0
               ? "compliant cable"
               : fmt::format("{:g} of the compliance in the cable", *structure.cable_share);
}

Matrix3 structural_compliance_m_per_N(const device::DeviceDescription &device,
                                      const Structure &structure, const Vector3 &q_rad) {
    Matrix3 compliance =
        structure.at_tip() / device.structure.stiffness_N_per_m * Matrix3::Identity();
    if (structure.in_cable() > 0.0) {
        const Matrix3 J = device::motor_jacobian(device.geometry, q_rad);
        const auto cables = device::cable_compliance(device, structure.in_cable());
        for (std::size_t j = 0; j < cables.size(); ++j) {
            const Vector3 along = J.col(static_cast<Eigen::Index>(j));
            compliance += along * along.transpose() / cables[j].stiffness_Nm_per_rad;
        }
    }
    return compliance;
}

Matrix3 felt_stiffness_N_per_m(const Matrix3 &rendered_N_per_m, const Matrix3 &compliance_m_per_N) {
    return (Matrix3::Identity() + rendered_N_per_m * compliance_m_per_N)
        .partialPivLu()
        .solve(rendered_N_per_m);
}

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
