// The gains of motors that are driven at another dR than the tuning's, and the voltage that makes
// up for that of their brushes.
//
// *K_q is what must be equal, not dR.* A motor whose R is not known yet, or not trusted, or that
// the winding guard limits, is driven at dR_j = s_j dR. With K_P and K_D times s_j its K_q (20)
// stays k_T K_P/dR, and with it the direction of the force at rest. For slow motions the sampled
// coupling (12) is, with a = T (½ + d) for the lag of its voltage,
//
//   −τ/θ = k_T/dR [ K_P + jω (k_T + K_D − K_P (L/dR + a)) + … ]
//
// which damps while K_P ≤ P = (k_T + K_D)/(L/dR + a). With dR, K_P and K_D times s, and both gains
// times a share c of all motors,
//
//   c K_P ≤ P(s, c) = (k_T + s c K_D)/(L/dR + s a)
//
// A motor whose lag costs more than its K_D gives comes nearer to this limit the larger s is. That
// its K_P stays the same share of it as at s = 1 requires, whatever K_P,
//
//   c = k_T / (P(1, 1) (L/dR + s a) − s K_D) = k_T / (k_T + (s − 1)(a P(1, 1) − K_D)),    at most 1
//
// c falls where k_T a > K_D L/dR, and is above 1/s. Direction before stiffness: all three motors
// get the smallest c of any. The margin is the factor by which both gains may rise until a loop of
// the device, with or without a hand, is unstable by its eigenvalues. In 7000 random tunings at 0.5
// to 4 kHz, d from 0 to 1.5, s up to 4, it falls by 2 % or more in 1.6 %, and by 10.3 % at most;
// without c it falls by more than 10 % in a tenth of them, and to a fourth.
//
// *Brushes and bridge.* In dR i + V_b tanh(i/i_b) = e_W at rest, the second term takes V_b/dR off
// the current of the law's spring, i* = s c K_P (θ_Sd − θ)/dR_j. The law adds V̂ tanh(i*/i_c), as a
// function of its own voltage: a measured current would be fed back. With V̂ ≤ V_b and i_c ≥ i_b it
// is at most V_b tanh(i*/i_b), so that i is nowhere above i*, and nowhere farther below it than
// without. What it adds to the slope of e_W is a share V̂/(i_c dR_j) at most, where i* is 0; where
// i_b is small, V_b tanh(i/i_b) has no slope there any more, and all of that share is taken from
// the margin. So i_c ≥ V̂/(kMaxBrushSlope dR_j). In 1329 such tunings with a margin of 1.25 or
// more, K_P times 1.15 left at least 1.05; tunings as found have 1.3. In free space i* is 0. In
// contact the force of a count, k_T K_P/dR for each, is larger by that share at most.
#pragma once

#include "device/core/motor/motor.h"
#include "engine/control/tuning.h"
#include "engine/control/winding_observer.h"

#include <algorithm>
#include <cmath>

namespace springdrive::control {

/// The share c for a motor driven at `dR_Ohm`. RT-safe.
/// @param lag_s  a = T (½ + d), from a measurement to the middle of the voltage computed from it
[[nodiscard]] inline double allowed_stiffness_share(const device::MotorParameters &motor,
                                                    const Tuning &tuning, double dR_Ohm,
                                                    double lag_s) noexcept {
    const double k_T = motor.torque_constant_Nm_per_A;
    const double K_D = tuning.K_D_Vs_per_rad;
    const double tuned_Ohm = device::residual_resistance_Ohm(motor, tuning.dR_Ohm);
    const double limit_V_per_rad = (k_T + K_D) / (motor.inductance_H / tuned_Ohm + lag_s);
    const double lost = (dR_Ohm / tuned_Ohm - 1.0) * (limit_V_per_rad * lag_s - K_D);
    return k_T / (k_T + std::max(0.0, lost));
}

/// By which share the compensation of V_b may raise a motor's K_P.
inline constexpr double kMaxBrushSlope = 0.15;

/// The largest i_b [A]: that of graphite brushes, from 10 to 200 mA.
inline constexpr double kMaxBrushCurrent_A = 0.2;

/// So many standard deviations are taken off an estimated V_b.
inline constexpr double kBrushDeviations = 2.0;

/// V̂ tanh(i*/i_c) [V]. RT-safe.
/// @param spring_V  dR_j i*, the part of e_W that K_P makes
[[nodiscard]] inline double brush_compensation_V(const ObservedMotor &motor, double spring_V,
                                                 double dR_Ohm) noexcept {
    const double V_hat = motor.brush_voltage_V - kBrushDeviations * motor.brush_deviation_V;
    if (!(V_hat > 0.0)) {
        return 0.0;
    }
    const double i_c_A = std::max(kMaxBrushCurrent_A, V_hat / (kMaxBrushSlope * dR_Ohm));
    return V_hat * std::tanh(spring_V / (dR_Ohm * i_c_A));
}

} // namespace springdrive::control
