// Description of a haptic device. Its data are kept in assets/devices/*.toml, not in code.
#pragma once

#include "base/vector.h"
#include "device/core/motor/motor.h"
#include "device/core/phantom/kinematics.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <string>

namespace springdrive::device {

/// Of one motor. Deviations are standard deviations. Resistances are as its amplifier sees them,
/// R/(1 + g) with the gain error g of its current sensor, which nothing here tells.
struct MotorCalibration {
    double resistance_Ohm = 0.0;           ///< at 25 °C, averaged over the commutator's angles
    double resistance_deviation_Ohm = 0.0; ///< without that of the air's temperature
    // R(θ) less its mean is the sum of cos(n s θ) and sin(n s θ) with these, n = 1 and 2.
    double ripple_cos_Ohm = 0.0;
    double ripple_sin_Ohm = 0.0;
    double ripple_deviation_Ohm = 0.0; ///< of each of the two
    double ripple_cos_2_Ohm = 0.0;
    double ripple_sin_2_Ohm = 0.0;
    double ripple_2_deviation_Ohm = 0.0;
    double torque_constant_Nm_per_A = 0.0; ///< by back-EMF
    double torque_constant_deviation_Nm_per_A = 0.0;
    double offset_A = 0.0; ///< of the current's sensor
    double offset_deviation_A = 0.0;
    // Of brushes and bridge, V_b tanh(i/i_b); R is without it.
    double brush_voltage_V = 0.0;     ///< V_b
    double brush_deviation_V = 0.0;   ///< 0: not measured, as in calibrations of before
    double min_brush_current_A = 0.0; ///< i_b, between this
    double max_brush_current_A = 0.0; ///< and this, 95 of 100
};

/// By which an angle may be off that a person found by eye, the zero pose of a joint [rad]: 2°.
inline constexpr double kZeroByEye_rad = 0.0349;

/// What was learned of one device beyond the file of its kind, and by whom.
struct Calibration {
    std::string serial;         ///< of the device, as in DeviceIdentity, like the next two
    std::string kind;           ///< "simulated", "USB"
    std::string firmware;       ///< empty if it was read from a board
    std::int64_t made_at_s = 0; ///< UTC, since 1970
    double air_C = 25.0;        ///< of the air then,
    double air_error_K = 10.0;  ///< to within so much, either way
    std::array<MotorCalibration, 3> motor;

    /// Whether counts and sensors' offsets are those of the calibration whenever the device is
    /// opened: they are those of a simulated device. A board counts from 0 after each power-up, so
    /// that its zero is found by eye again, and measures its sensors' offsets anew.
    [[nodiscard]] bool has_lasting_zero() const { return kind == "simulated"; }
};

/// "2026-11-25T05:10:22Z".
[[nodiscard]] std::string text_of_utc(std::int64_t seconds_since_1970);

/// A box in which the device moves comfortably; scenes are fitted into it.
struct Workspace {
    Vector3 centre_m{Vector3::Zero()};
    Vector3 size_m{Vector3::Zero()};
};

/// Limits that the safety monitor enforces, in addition to those of the motors. No panel or option
/// raises them.
struct DeviceLimits {
    double tip_force_N = 0.0; ///< of the rendered force
    double tip_speed_m_per_s = 0.0;
    double beyond_stops_rad = 0.0;   ///< how far stops may yield; more means an encoder error
    double generated_energy_J = 0.0; ///< that the hand may receive beyond what it put in
    double late_s = 0.0;             ///< how long consecutive missed deadlines may last
    double stale_s = 0.0;            ///< how long no new measurement may arrive
    double window_silence_s = 0.0;   ///< how long the window's heartbeat may be absent
};

/// A soft wall before the joints' stops: a spring and a damper at each joint.
struct WorkspaceEdge {
    double margin_rad = 0.0; ///< distance before a stop at which it begins
    double stiffness_Nm_per_rad = 0.0;
    double damping_Nms_per_rad = 0.0;
};

/// Friction of joints and transmission, at each joint.
struct JointFriction {
    double viscous_Nms_per_rad = 0.0;
    Vector3 coulomb_Nm{Vector3::Zero()}; ///< the same at rest and in motion
};

/// The joints' range of travel between their stops.
struct JointLimits {
    Vector3 min_rad{Vector3::Zero()};
    Vector3 max_rad{Vector3::Zero()};
    double min_q3_minus_q2_rad = 0.0; ///< the links fold no further
    double max_q3_minus_q2_rad = 0.0;

    [[nodiscard]] bool allow(const Vector3 &q_rad) const {
        const double fold_rad = q_rad[2] - q_rad[1];
        return (q_rad.array() >= min_rad.array()).all() &&
               (q_rad.array() <= max_rad.array()).all() && fold_rad >= min_q3_minus_q2_rad &&
               fold_rad <= max_q3_minus_q2_rad;
    }
};

/// Compliance between rotors and tip, of cables and links. A data sheet tells only the whole.
struct StructuralCompliance {
    double stiffness_N_per_m = 0.0; ///< K, of all that lies between rotor and tip
    double damping_Ns_per_m = 0.0;  ///< b, beside K
    /// s, the cables' share of the compliance 1/K; the rest is between linkage and tip. Empty:
    /// unknown, anything from 0 to 1.
    std::optional<double> cable_share;
    /// Of a rotor that swings on its cable, relative to critical. The default is assumed, as much
    /// as b is of a tip of 0.1 kg. Not from b/K, which would damp the faster swing of a stiffer
    /// cable more, by up to 0.3 of critical at s = 0.1: steel is no dashpot.
    double cable_damping_ratio = 0.03;
};

/// How the winding currents are measured: by the amplifiers, for (6), and by a converter, for the
/// servo.
struct CurrentSensing {
    double resolution_A = 0.0; ///< of the converter
    double noise_A = 0.0;      ///< r.m.s. of the converter, each period's independent
    double max_offset_A = 0.0; ///< either way, constant
    double gain_tolerance = 0.0;
    bool is_shared = true; ///< one sensor for amplifier and converter: their errors are the same
};

struct DeviceDescription {
    std::string name;
    PhantomGeometry geometry;
    LinkageInertia inertia;
    JointFriction friction;
    JointLimits joint_limits;
    StructuralCompliance structure;
    std::array<MotorParameters, 3> motor;
    AmplifierParameters amplifier;
    CurrentSensing current_sensing;
    int encoder_counts_per_turn = 0; ///< of the motor shaft, after ×4 decoding
    Workspace workspace;
    WorkspaceEdge edge;
    DeviceLimits limits;
    std::optional<Calibration> calibration; ///< of one device; without, only its kind is known

    /// By which share R of a motor, as its amplifier sees it, may differ from the file's.
    [[nodiscard]] double resistance_tolerance(std::size_t motor_index) const {
        return motor[motor_index].resistance_tolerance + current_sensing.gain_tolerance;
    }

    /// One encoder count, in motor angle.
    [[nodiscard]] double rad_per_count() const {
        return 2.0 * std::numbers::pi / encoder_counts_per_turn;
    }
};

/// The tip's side of a structure of which the share s of the compliance is in the cables: K/(1 − s)
/// and b/(1 − s), both infinite, that is rigid, at s = 1. RT-safe.
[[nodiscard]] inline StructuralCompliance tip_compliance(const StructuralCompliance &whole,
                                                         double cable_share) {
    StructuralCompliance tip = whole;
    if (cable_share < 1.0) {
        tip.stiffness_N_per_m /= 1.0 - cable_share;
        tip.damping_Ns_per_m /= 1.0 - cable_share;
    } else {
        tip.stiffness_N_per_m = std::numeric_limits<double>::infinity();
        tip.damping_Ns_per_m = std::numeric_limits<double>::infinity();
    }
    return tip;
}

/// The cable between a rotor and its joint, a spring with a damper, in rotor coordinates. Infinite:
/// rigid.
struct CableCompliance {
    double stiffness_Nm_per_rad = std::numeric_limits<double>::infinity();
    double damping_Nms_per_rad = std::numeric_limits<double>::infinity();
};

/// The cables' side: of motor j, with the rotor's inertia J_m and the damping ratio ζ,
///
///   κ = (K/s) (JᵀJ)_jj       c = 2 ζ √(κ J_m)       J = ∂x/∂θ at the default pose
///
/// so that there a tip held by that motor alone yields by s/K, along column j of J. Rigid at s = 0.
/// RT-safe.
[[nodiscard]] inline std::array<CableCompliance, 3>
cable_compliance(const DeviceDescription &device, double cable_share) {
    std::array<CableCompliance, 3> cables;
    if (!(cable_share > 0.0)) {
        return cables;
    }
    const Matrix3 J = motor_jacobian(device.geometry, default_pose_rad());
    for (std::size_t j = 0; j < cables.size(); ++j) {
        const double stiffness_Nm_per_rad = device.structure.stiffness_N_per_m / cable_share *
                                            J.col(static_cast<Eigen::Index>(j)).squaredNorm();
        cables[j] = {stiffness_Nm_per_rad,
                     2.0 * device.structure.cable_damping_ratio *
                         std::sqrt(stiffness_Nm_per_rad * device.motor[j].rotor_inertia_kg_m2)};
    }
    return cables;
}

/// Whether the tip can be at `tip_m`, within reach and joint limits. RT-safe.
[[nodiscard]] inline bool can_reach(const DeviceDescription &device, const Vector3 &tip_m) {
    const std::optional<Vector3> q_rad = joint_angles_rad(device.geometry, tip_m);
    return q_rad && device.joint_limits.allow(*q_rad);
}

} // namespace springdrive::device
