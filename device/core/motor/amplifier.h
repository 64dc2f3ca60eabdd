// Amplifiers that drive a winding: the spring drive of the paper, or a current drive for
// comparison, both within supply voltage and current limit.
#pragma once

#include "device/core/motor/motor.h"

#include <cstdint>

namespace springdrive::device {

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
