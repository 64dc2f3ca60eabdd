// What drives a winding: the spring drive of the paper, or a current drive for comparison, both
// within what supply and current limit allow.
#pragma once

#include "device/core/motor/motor.h"

#include <cstdint>

namespace springdrive::device {

enum class AmplifierKind : std::uint8_t {
    spring_drive,  ///< e_A = R̂ i + e_W (6)
    current_drive, ///< holds a commanded current, ideal up to its bandwidth
};

/// What a winding does over a sub-step, for a rotor that turns at a steady ω̄ meanwhile: the current
/// at its end and its mean are both affine in ω̄.
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
    double resistance_Ohm = 0.0; ///< R(T, θ), the true one
    double current_A = 0.0;
    double rate_rad_per_s = 0.0; ///< of the rotor
    bool limited = true;         ///< whether supply and current limit hold
};

/// The spring drive over a sub-step of `step_s`. Where R̂ i + e_W exceeds the supply, or from when
/// on it does, the rail takes its place, and the whole R is back. Where it would drive a current on
/// that is above its limit when the step begins, the voltage falls back to what sustains that limit
/// at standstill. RT-safe.
[[nodiscard]] CurrentStep spring_drive_step(const MotorParameters &motor, const DriveState &now,
                                            double e_W_V, double cancelled_resistance_Ohm,
                                            double step_s);

/// The current drive: di/dt = ω_b (i_commanded − i) with the bandwidth ω_b, as long as the supply
/// suffices for e_A = R i + L di/dt + k_T θ̇; else the rail. Exact for a steady rotor. RT-safe.
[[nodiscard]] CurrentStep current_drive_step(const MotorParameters &motor, const DriveState &now,
                                             double commanded_A, double bandwidth_rad_per_s,
                                             double step_s);

// The same two amplifiers on windings without inductance, whose current follows at once: (11) with
// L = 0, i = (e_W − k_T θ̇)/dR. The current of the end and the mean one then go with ω̄ alike.

/// An over-cancelled winding would have no current to settle at: dR is taken to be no less than
/// kLeastResidualShare of R. Supply and current limit are judged at the rate of the step's start.
/// RT-safe.
[[nodiscard]] CurrentStep spring_drive_at_once(const MotorParameters &motor, const DriveState &now,
                                               double e_W_V, double cancelled_resistance_Ohm);

/// The commanded current, as long as the supply suffices for e_A = R i + k_T θ̇; else the rail.
/// RT-safe.
[[nodiscard]] CurrentStep current_drive_at_once(const MotorParameters &motor, const DriveState &now,
                                                double commanded_A);

} // namespace springdrive::device
