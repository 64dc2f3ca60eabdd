// The subject of a stability analysis: a device, its drive, sampling and configuration, and the
// hands that hold it.
#pragma once

#include "device/core/device_description.h"
#include "device/core/motor/motor.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/rendered_force.h"
#include "engine/control/tuning.h"
#include "engine/lab/loops/hand_family.h"
#include "engine/lab/loops/linear_loop.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace springdrive::loops {

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
    /// One motor with this load instead of the device; its own rotor is included.
    std::optional<device::RotorLoad> rotor;
    /// The actual net resistance where it differs from what a drive can be set to, for example
    /// after a winding has cooled. It may be negative.
    std::optional<double> net_resistance_Ohm;

    /// dR of a motor.
    [[nodiscard]] double dR_Ohm(const device::MotorParameters &motor) const {
        return net_resistance_Ohm.value_or(device::residual_resistance_Ohm(motor, tuning.dR_Ohm));
    }
    [[nodiscard]] Sampling sampling() const { return {period_s, delay_periods}; }
};

/// Each motor of a device alone, at the zero pose, without a hand and under K_P, K_D and η only: a
/// mode of the transpose map with eigenvalue a of α JᵀJ is the loop with η = 1 − a.
[[nodiscard]] StabilityCase motors_alone(const device::DeviceDescription &device,
                                         const control::Tuning &tuning);

/// One of the loops that must all be stable.
struct LoopMember {
    int motor = 0; ///< the one that moves; ignored with three
    Hand hand;
};

/// Each hand with each motor, or with all at once.
[[nodiscard]] std::vector<LoopMember> members(const StabilityCase &which);

/// The share of a motion that the law treats as an error: (1 − η) G C J with G the map and C = I,
/// the tip held at a point in all directions. With the transpose map this is (1 − η) α W⁻¹ Jᵀ J,
/// with the inverse map (1 − η) I; for one motor, its largest eigenvalue.
[[nodiscard]] Eigen::MatrixXd held_share(const StabilityCase &which);

/// The load at a configuration, in motor coordinates: rotors, linkage and hand. Weight and Coriolis
/// forces are negligible near rest.
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

} // namespace springdrive::loops
