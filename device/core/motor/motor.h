// A brushed DC motor behind an amplifier, the spring drive of the paper, equations (1)–(8) and
// (11), or a current drive for comparison, both within supply voltage and current limit.
#pragma once

#include <algorithm>
#include <cstdint>

namespace springdrive::device {

/// A motor's thermal network, winding to housing to air, as in data sheets.
struct ThermalParameters {
    double winding_housing_K_per_W = 0.0;
    double housing_ambient_K_per_W = 0.0;
    double winding_time_s = 0.0; ///< time constant, winding to housing
    double motor_time_s = 0.0;   ///< time constant, housing to air
    double max_winding_C = 0.0;
};

/// Data sheet of one motor and the limits of its amplifier. The values come from a device file.
struct MotorParameters {
    double resistance_Ohm = 0.0;           ///< R, winding resistance at 25 °C
    double inductance_H = 0.0;             ///< L
    double torque_constant_Nm_per_A = 0.0; ///< k_T, also in V·s/rad
    double rotor_inertia_kg_m2 = 0.0;
    double supply_V = 0.0;              ///< largest |e_W| that the amplifier passes on
    double peak_current_A = 0.0;        ///< stall current; the safety monitor trips above it
    double resistance_rise_per_K = 0.0; ///< of R(T), relative to R at 25 °C
    double commutation_ripple = 0.0;    ///< of R(θ): amplitude as a share of R
    int commutator_segments = 0;        ///< ripples per turn
    double commutator_phase_rad = 0.0;  ///< of the ripple at θ = 0; unknown of a real motor
    /// Of the ripple's second harmonic, of a simulated motor: amplitude as a share of R, and phase.
    double second_harmonic = 0.0;
    double second_harmonic_phase_rad = 0.0;
    ThermalParameters thermal;
    double resistance_tolerance = 0.0;      ///< of R, as a share of it, either way
    double torque_constant_tolerance = 0.0; ///< of k_T
    /// V_b of brushes and bridge, V_b tanh(i/i_b) with the sign of the current, is between 0 and
    /// this.
    double max_brush_voltage_V = 0.5;
    double torque_constant_fall_per_K = 0.0; ///< of k_T, relative to k_T with the housing at 25 °C
    double max_torque_ripple = 0.0;          ///< of k_T(θ): amplitude as a share of k_T
};

/// Limits of the amplifiers' settings; the three amplifiers are identical.
struct AmplifierParameters {
    double max_cancelled_Ohm = 0.0;    ///< the largest R̂ of (6) that can be set
    double current_bandwidth_hz = 0.0; ///< of the current drive used for comparison
};

/// Minimum share of R that an amplifier leaves, so that the net resistance stays positive (7).
inline constexpr double kMinResidualShare = 0.005;

/// The dR that results from a requested `dR_Ohm`: R̂ = R − dR can be neither negative nor closer to
/// R than kMinResidualShare.
[[nodiscard]] constexpr double residual_resistance_Ohm(const MotorParameters &motor,
                                                       double dR_Ohm) {
    return std::clamp(dR_Ohm, kMinResidualShare * motor.resistance_Ohm, motor.resistance_Ohm);
}

/// K_L = k_T²/L (4) [N·m/rad]: the inductance as a spring; also K_HF (14).
[[nodiscard]] constexpr double inductive_stiffness_Nm_per_rad(const MotorParameters &motor) {
    return motor.torque_constant_Nm_per_A * motor.torque_constant_Nm_per_A / motor.inductance_H;
}

/// B_dR = k_T²/dR (8) [N·m·s/rad]: the residual resistance as a damper in series with K_L. With R
/// instead of dR it is B_R of (5).
[[nodiscard]] constexpr double series_damping_Nms_per_rad(const MotorParameters &motor,
                                                          double resistance_Ohm) {
    return motor.torque_constant_Nm_per_A * motor.torque_constant_Nm_per_A / resistance_Ohm;
}

/// K_DC = k_T K_P/dR (13) [N·m/rad]: the static stiffness between rotor and set-point.
/// @param dR_Ohm  the requested value, limited by `residual_resistance_Ohm`
[[nodiscard]] constexpr double static_stiffness_Nm_per_rad(const MotorParameters &motor,
                                                           double K_P_V_per_rad, double dR_Ohm) {
    return motor.torque_constant_Nm_per_A * K_P_V_per_rad / residual_resistance_Ohm(motor, dR_Ohm);
}

/// A winding's response over a time h with constant e_W and rotor velocity.
///
/// With (6) in (1) the winding obeys (11), L di/dt = e_W − dR i − k_T θ̇, so with the net voltage
/// u = e_W − k_T θ̇ held constant, and z = dR h/L,
///
///   i(h)    = e^(−z) i(0) + (h/L) φ₁(−z) u
///   mean i  = φ₁(−z) i(0) + (h/L) φ₂(−z) u       φ₁(x) = (eˣ − 1)/x,  φ₂(x) = (φ₁(x) − 1)/x
///
/// Exact for every dR including zero and negative values, for which the current of an
/// over-cancelled winding grows as in reality.
struct WindingStep {
    double decay = 1.0;             ///< e^(−z)
    double gain_A_per_V = 0.0;      ///< i(h) per volt of u
    double mean_decay = 1.0;        ///< mean of i over the step, per ampere of i(0)
    double mean_gain_A_per_V = 0.0; ///< mean of i over the step, per volt of u
};

[[nodiscard]] WindingStep winding_step(const MotorParameters &motor, double residual_resistance_Ohm,
                                       double step_s);

/// The load of a rotor, reduced to motor coordinates.
struct RotorLoad {
    double inertia_kg_m2 = 0.0;
    double damping_Nms_per_rad = 0.0;
    double stiffness_Nm_per_rad = 0.0; ///< to ground
};

enum class AmplifierKind : std::uint8_t {
    spring_drive,  ///< e_A = R̂ i + e_W (6)
    current_drive, ///< holds a commanded current, ideal up to its bandwidth
};

/// A winding's current over a sub-step, for a rotor that turns at a constant ω̄: the current at the
/// end and the mean current are both affine in ω̄.
struct CurrentStep {
    double end_A = 0.0; ///< at ω̄ = 0
    double end_As_per_rad = 0.0;
    double mean_A = 0.0; ///< at ω̄ = 0
    double mean_As_per_rad = 0.0;

    [[nodiscard]] double end_at(double rate) const { return end_A + end_As_per_rad * rate; }
    [[nodiscard]] double mean_at(double rate) const { return mean_A + mean_As_per_rad * rate; }
};

/// The state of one motor at the start of a sub-step.
struct DriveState {
    double resistance_Ohm = 0.0; ///< the true R(T, θ)
    double current_A = 0.0;
    double rate_rad_per_s = 0.0; ///< of the rotor
    bool limited = true;         ///< whether supply and current limits apply
};

/// The spring drive over a sub-step of `step_s`. While R̂ i + e_W exceeds the supply, it is
/// replaced by the supply voltage, behind the full R. If it would further increase a current that
/// is above its limit when the step begins, the voltage falls back to what sustains that limit at
/// standstill. RT-safe.
[[nodiscard]] CurrentStep spring_drive_step(const MotorParameters &motor, const DriveState &now,
                                            double e_W_V, double cancelled_resistance_Ohm,
                                            double step_s);

/// The current drive: di/dt = ω_b (i_commanded − i) with the bandwidth ω_b, while the supply
/// suffices for e_A = R i + L di/dt + k_T θ̇; otherwise the supply voltage. Exact for a constant
/// rotor velocity. RT-safe.
[[nodiscard]] CurrentStep current_drive_step(const MotorParameters &motor, const DriveState &now,
                                             double commanded_A, double bandwidth_rad_per_s,
                                             double step_s);

// The same two amplifiers on windings without inductance, whose current follows immediately: (11)
// with L = 0, i = (e_W − k_T θ̇)/dR. End and mean current then depend on ω̄ in the same way.

/// An over-cancelled winding would have no steady current, so dR is at least kMinResidualShare of
/// R. Supply and current limit are evaluated at the rate at the start of the step. RT-safe.
[[nodiscard]] CurrentStep spring_drive_at_once(const MotorParameters &motor, const DriveState &now,
                                               double e_W_V, double cancelled_resistance_Ohm);

/// The commanded current, while the supply suffices for e_A = R i + k_T θ̇; otherwise the supply
/// voltage. RT-safe.
[[nodiscard]] CurrentStep current_drive_at_once(const MotorParameters &motor, const DriveState &now,
                                                double commanded_A);

} // namespace springdrive::device
