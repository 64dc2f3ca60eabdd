// Whether the coupling that a sampled spring drive renders is passive. The paper takes it for
// granted; it is more than stability with a family of hands.
//
// In continuous time (12) is passive where K_P + K_D λ ≤ k_T dR/L and K_P ≤ (k_T + K_D) dR/L.
// Sampled, a motion at ω answers with torques at all Ω_n = ω + 2πn/T, n = …, −1, 0, 1, …, and
// motions at all of them reach the servo as one. With v_n the rotor's velocity at Ω_n, the power
// that it puts into the port is, from (1), (2), (6), with b for viscous friction,
//
//   P = Σ g_n |v_n|² + Re Σ v̄_n q_n Σ v_m/(jΩ_m)
//   Y_n = 1/(dR + jΩ_n L),   g_n = k_T² Re Y_n + b,   q_n = k_T Y_n H_n C
//   H_n = e^(−jΩ_n dT) (1 − e^(−jωT))/(jΩ_n T),   C = K_P + K_D D(e^(jωT)),  see linear_loop.h
//
// *Passive*: no v_n makes P negative. With c_n = conj(1/(jΩ_n)) this is
//
//   1 + ½ [ Re Σ c̄q/g − √( Σ|q|²/g · Σ|c|²/g − (Im Σ c̄q/g)² ) ] ≥ 0     for 0 < ω ≤ π/T
//
// the least eigenvalue of P relative to Σ g|v|². As |Y_n|²/g_n = 1/(D − bL²s²), s = jΩ_n, D = dR
// (k_T² + b dR), the sums split into those of 1/s², 1/s and 1/(s ± p), p² = D/(bL²), and these are
// geometric series (Poisson). Without friction they diverge: what shakes a rotor fast enough gets
// energy out of any servo.
//
// *Stable with every linear hand*, and whatever linear and passive is between it and the rotor: at
// each Ω_n that is a reactance x_n g_n and perhaps losses. The loop is 1 + Σ c̄q/g /(1 + jx_n),
// where each term is on a circle through 0 and c̄q/g, and the sum of such discs has 0 outside if
//
//   | 1 + ½ Σ c̄q/g | > ½ Σ |c q|/g
//
// then also with smaller gains, as discs hold 0. This is less: the hand may not change in time. It
// is more than the term n = 0 alone, g_0 + Re q_0/(jω) ≥ 0, which holds for hands that no alias
// reaches.
//
// (30) at η = 1 − a has C_a = a (K_P + K_D D) − (1 − a) k_T D, as each mode of the transpose map
// with an eigenvalue a. P is affine in C, and its least concave: for passivity the ends a = 0, free
// space, and a = 1 suffice; for linear hands some between are tried.
#pragma once

#include "engine/lab/loops/rendered_stiffness.h"

#include <string>

namespace springdrive::loops {

/// A motor at the port: friction and what the law treats as an error.
struct Port {
    double damping_Nms_per_rad = 0.0; ///< b, at the rotor
    double held = 1.0;                ///< a: 0 free space, 1 rigid
};

/// The least eigenvalue above: at most 1, passive from 0 on; −∞ where dR or b is not above 0.
[[nodiscard]] double least_absorbed(const SpringDrive &drive, const Port &port,
                                    double omega_rad_per_s);

/// The difference of the two sides of the condition for linear hands; −∞ where dR or b is not
/// above 0.
[[nodiscard]] double distance_to_linear_hands(const SpringDrive &drive, const Port &port,
                                              double omega_rad_per_s);

/// The least of one of these, over frequencies up to half the servo's rate and over a.
struct LeastAtPort {
    double value = 0.0;
    double omega_rad_per_s = 0.0;
    double held = 1.0; ///< a

    [[nodiscard]] bool holds() const { return value >= 0.0; }
};

[[nodiscard]] LeastAtPort passivity(const SpringDrive &drive, double damping_Nms_per_rad);
[[nodiscard]] LeastAtPort stability_with_linear_hands(const SpringDrive &drive,
                                                      double damping_Nms_per_rad);

// Of a device, whose motors render modes of the transpose map with α up to (29), or the inverse
// map: with the least b of all at each motor, it is passive where such a motor is. Where motors
// differ, each is taken by itself, and the worst counts. Friction is in the joint: behind a cable
// with the damper c, a rotor that turns at v still meets b v_l² + c (v − v_l)² ≥ bc/(b + c) v², so
// that is b with such a structure, and what remains is passive. η and hands of the case do not
// enter.

[[nodiscard]] LeastAtPort passivity(const StabilityCase &which);
[[nodiscard]] LeastAtPort stability_with_linear_hands(const StabilityCase &which);

/// "passive", or what is known instead: "stable with every linear hand, active at 90 Hz in
/// contact", "active at 90 Hz in free space, and unstable with some hand".
[[nodiscard]] std::string port_text(const LeastAtPort &passive, const LeastAtPort &linear_hands);

} // namespace springdrive::loops
