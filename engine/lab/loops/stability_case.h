// The subject of a stability analysis: a device, its drive, sampling and configuration, the places
// where its structure may be compliant, and the hands that hold it; and the parameters that such an
// analysis varies.
#pragma once

#include "base/assertions.h"
#include "device/core/device_description.h"
#include "device/core/hand_parameters.h"
#include "device/core/motor/motor.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/rendered_force.h"
#include "engine/control/tuning.h"
#include "engine/lab/loops/linear_loop.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::loops {

// The hands with which a device must be stable: from a fingertip that barely touches it to a firm
// grip. A device counts as stable only if it is with every one of them.
//
// The values are assumed, of the order that the literature on grips gives; the middle of the family
// is the relaxed pen grip of `HandParameters`, its ends are farther by a factor of 5 in mass and
// damping and of 10 in stiffness.

/// The linear model of a hand for small motions about rest: a mass on the tip, tied to the ground
/// by spring and damper.
struct Hand {
    std::string name;
    double mass_kg = 0.0;
    double damping_Ns_per_m = 0.0;
    double stiffness_N_per_m = 0.0;
};

/// The device is not held.
[[nodiscard]] inline Hand no_hand() { return {"no hand", 0.0, 0.0, 0.0}; }

/// A hand of the family.
/// @param firmness  from 0, a light fingertip, over 0.5, a relaxed grip, to 1, a firm one
[[nodiscard]] inline Hand hand_of_firmness(double firmness) {
    const device::HandParameters relaxed;
    const double way = 2.0 * firmness - 1.0;
    return {"firmness " + std::to_string(firmness).substr(0, 4),
            relaxed.mass_kg * std::pow(5.0, way), relaxed.damping_Ns_per_m * std::pow(5.0, way),
            relaxed.stiffness_N_per_m * std::pow(10.0, way)};
}

/// Text for messages: "light hand", "hand of firmness 0.25", "no hand".
[[nodiscard]] inline std::string hand_text(const std::string &name) {
    return name.ends_with("hand")          ? name
           : name.starts_with("firmness ") ? "hand of " + name
                                           : name + " hand";
}

/// No hand, and `grips` of the family from light to firm, evenly spread. @pre at least two grips
[[nodiscard]] inline std::vector<Hand> hand_family(int grips = 5) {
    SPRINGDRIVE_ASSERT(grips >= 2);
    std::vector<Hand> hands{no_hand()};
    for (int i = 0; i < grips; ++i) {
        hands.push_back(hand_of_firmness(static_cast<double>(i) / (grips - 1)));
    }
    hands[1].name = "light";
    hands.back().name = "firm";
    return hands;
}

/// Where the compliance between motors and tip is, see `cable_compliance` of the device. A part
/// with less than `kRigidShare` of it has none, and the other one all: its modes are far above all
/// others.
struct Structure {
    std::optional<double> cable_share; ///< s, 0 to 1; nothing: everything is rigid

    static constexpr double kRigidShare = 1e-3;

    /// s; zero where nothing gives in the cable.
    [[nodiscard]] double in_cable() const {
        const double share = cable_share.value_or(0.0);
        return share < kRigidShare ? 0.0 : share > 1.0 - kRigidShare ? 1.0 : share;
    }
    /// 1 − s; zero where nothing gives at the tip.
    [[nodiscard]] double at_tip() const { return cable_share ? 1.0 - in_cable() : 0.0; }
};

/// Rigid, all at the tip, all in the cable and half of each: where the split is not known.
[[nodiscard]] inline std::vector<Structure> all_structures() { return {{}, {0.0}, {1.0}, {0.5}}; }

/// Text for messages: "rigid links", "compliant tip", "compliant cable", "0.5 of the compliance in
/// the cable".
[[nodiscard]] std::string structure_text(const Structure &structure);

/// Which motors move.
enum class Freedom : std::uint8_t {
    one_motor,    ///< each motor alone, the other joints locked: the paper's 1-DOF
    three_motors, ///< the whole linkage
};

struct StabilityCase {
    device::DeviceDescription device;
    device::AmplifierKind drive = device::AmplifierKind::spring_drive;
    control::Tuning tuning;    ///< a current drive uses only its λ and η
    control::VirtualWall wall; ///< of a current drive
    double period_s = 1e-3;
    double delay_periods = 0.0;
    Vector3 q_rad = device::default_pose_rad();
    Freedom freedom = Freedom::one_motor;
    std::vector<Hand> hands = hand_family();
    /// The device counts as stable only if it is with each of them, as with each hand.
    std::vector<Structure> structures{Structure{}};
    /// One motor with this load instead of the device; its own rotor is included, and it is rigid.
    std::optional<device::RotorLoad> rotor;
    /// The actual net resistance where it differs from what a drive can be set to, for example
    /// after a winding has cooled. It may be negative.
    std::optional<double> net_resistance_Ohm;

    /// dR of a motor.
    [[nodiscard]] double dR_Ohm(const device::MotorParameters &motor) const {
        return net_resistance_Ohm.value_or(device::residual_resistance_Ohm(motor, tuning.dR_Ohm));
    }
    [[nodiscard]] Sampling sampling() const { return {period_s, delay_periods}; }
    /// Whether links are rigid in all members.
    [[nodiscard]] bool is_rigid() const {
        return rotor || std::ranges::none_of(structures, [](const Structure &each) {
                   return each.cable_share.has_value();
               });
    }
};

/// Each motor of a device alone, at the zero pose, without a hand and under K_P, K_D and η only: a
/// mode of the transpose map with eigenvalue a of α JᵀJ is the loop with η = 1 − a.
[[nodiscard]] StabilityCase motors_alone(const device::DeviceDescription &device,
                                         const control::Tuning &tuning);

/// One of the loops that must all be stable.
struct LoopMember {
    int motor = 0; ///< the one that moves; ignored with three
    Hand hand;
    Structure structure{};
};

/// Each structure and hand with each motor, or with all at once.
[[nodiscard]] std::vector<LoopMember> members(const StabilityCase &which);

/// The share of a motion that the law treats as an error: (1 − η) G C J with G the map and C = I,
/// the tip held at a point in all directions. With the transpose map this is (1 − η) α W⁻¹ Jᵀ J,
/// with the inverse map (1 − η) I; for one motor, its largest eigenvalue.
[[nodiscard]] Eigen::MatrixXd held_share(const StabilityCase &which);

/// The load at a configuration: rotors, linkage and hand. Weight and Coriolis forces are negligible
/// near rest. On rigid links its coordinates are the motors'. Otherwise these are the rotors', and
/// further ones follow:
///
///   θ_l  of the linkage, in motor angles, behind cables:   τ = κ (θ_l − θ)
///   x    of the tip [m], with hand and tip load:           F = K/(1 − s) (x − J θ_l)
///
/// with κ of `cable_compliance`; with one motor, x is along its motion of the tip. A
/// hand without mass on a tip without load leaves nothing to move there: it is then tied to the
/// linkage, which is rigid at the tip.
[[nodiscard]] DrivenLoad driven_load(const StabilityCase &which, const LoopMember &member);

/// The servo's law for it: (10), (18) or (23), and (30), or the wall of a current drive.
[[nodiscard]] SampledLaw sampled_law(const StabilityCase &which, const LoopMember &member);

/// One member's load with the case's sampling, to be tried under laws.
[[nodiscard]] LinearLoop linear_loop(const StabilityCase &which, const LoopMember &member);

/// The largest |eigenvalue| of one member's loop, see linear_loop.h.
[[nodiscard]] double largest_eigenvalue(const StabilityCase &which, const LoopMember &member);

/// The member nearest to instability, or farthest beyond it.
struct WorstMember {
    LoopMember member;
    double eigenvalue = 0.0;

    [[nodiscard]] bool is_stable() const { return eigenvalue < 1.0 - kEigenvalueRoundOff; }
};

/// All of them, the most critical first.
[[nodiscard]] std::vector<WorstMember> ranked_members(const StabilityCase &which);

[[nodiscard]] WorstMember worst_member(const StabilityCase &which);

/// Whether every motion of every member decays, by the eigenvalues.
[[nodiscard]] bool is_stable(const StabilityCase &which);

/// What gives at the tip for a force on it while the motors hold still [m/N]:
/// J diag(1/κ) Jᵀ + (1 − s)/K I.
[[nodiscard]] Matrix3 structural_compliance_m_per_N(const device::DeviceDescription &device,
                                                    const Structure &structure,
                                                    const Vector3 &q_rad);

/// The stiffness that a hand feels at the tip, where the drive renders K_x at rigid links and the
/// structure gives C in series: (K_x⁻¹ + C)⁻¹ = (I + K_x C)⁻¹ K_x [N/m]. K_x may be singular.
[[nodiscard]] Matrix3 felt_stiffness_N_per_m(const Matrix3 &rendered_N_per_m,
                                             const Matrix3 &compliance_m_per_N);

// The parameters of a stability analysis: the list that command line, maps and tables read.

struct StabilityParameter {
    std::string_view name; ///< on the command line
    std::string_view symbol;
    std::string_view unit; ///< "–" where it has none
    double minimum = 0.0;  ///< of the meaningful range, inclusive
    double maximum = 0.0;
    double from = 0.0; ///< default range of the search for limits
    double to = 0.0;
    bool logarithmic = false;
    double (*get)(const StabilityCase &) = nullptr;
    void (*set)(StabilityCase &, double) = nullptr;
    std::string_view help;
};

[[nodiscard]] std::span<const StabilityParameter> stability_parameters();

/// Null for an unknown name.
[[nodiscard]] const StabilityParameter *stability_parameter_named(std::string_view name);

/// All names, separated by commas.
[[nodiscard]] std::string names_of_stability_parameters();

/// Why the parameter cannot have the value, with its range; empty when it can.
[[nodiscard]] std::string validate(const StabilityParameter &parameter, double value);

} // namespace springdrive::loops
