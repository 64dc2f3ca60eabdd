// The gains of motors that are driven at another dR than the tuning's, and the voltage that makes
// up for what their current lacks at rest.
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
// c falls where k_T a > K_D L/dR, and is above 1/s. Direction before stiffness: the others get the
// smallest c of any motor that carries a lasting force, from a tenth of the device's on. One that
// carries none, like the base's on a table's plane, is never known and does not turn the force. The
// share follows the load over 0.2 s, so that it is no stiffness of its own. The margin is the
// factor by which both gains may rise until a loop of the device, with or without a hand, is
// unstable by its eigenvalues. In 7000 random tunings at 0.5 to 4 kHz, d from 0 to 1.5, s up to 4,
// it falls by 2 % or more in 1.6 %, and by 10.3 % at most; without c it falls by more than 10 % in
// a tenth of them, and to a fourth.
//
// *What the current lacks.* At rest the current of the law's spring is i* = s c K_P (θ_Sd −
// θ)/dR_j. Brushes and bridge take V_b/dR_j off it, and an R that is not what it is taken for
// changes it by a share of itself. Over an interval, (1) with (6) leaves
//
//   v = ē_W − dR_j ī − k_T Δθ/T − L Δi/T = V_b tanh(i/i_b) + Δ i      dR_j + Δ = R − R̂
//
// however the motor moves, with the R̂ that was passed on. The law adds its slow mean u, du/dt = ω
// (v − u), so that i is i* at rest whatever V_b and Δ are. Seen from the rotor, the winding is then
//
//   Z(s) = L s + dR_j + Δ s/(s + ω)
//
// whose real part is between dR_j and dR_j + Δ = R − R̂, both above 0: as passive as without u. No
// gain rises but below ω. What makes up for V_b is not passive: a force that grows while it is held
// gives back more than it took, at most V_b/dR_j of current more.
//
// u is at most min(3 R |i*|, V_b,max): in free space, and where the force changes its sign, it is
// 0, and grows anew. A current that is measured wrongly can add no more than that. With R |i*| a
// motor that carries a tenth of the force would lack half of its current: the direction is off by
// 6.6° then at rest, against 2.5°, and a slope of 6 R makes it no better.
//
// *Only against a hand.* Within its dead zone, |e_W| < V_b, a motor damps nothing, and one that a
// trim takes out of it hunts if nothing else holds it: 58 counts wide at 0.2 V. What holds it is a
// hand, and that shows in a current that flows for a while, in any of the motors: a force that
// nothing balances does not last. Without it the trims fade.
#pragma once

#include "base/vector.h"
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

/// ω: 2 Hz. Contact's stiffness is then its own from 10 Hz on; a count makes 1 mV of u.
inline constexpr double kTrimRate_per_s = 12.6;

/// The force that lasts, against a hand. RT-safe.
class HeldForce {
public:
    /// @param current_A  of all motors, without their offsets
    void update(const Vector3 &current_A, double duration_s) noexcept {
        constexpr double kTime_s = 0.2;
        if (current_A.allFinite()) {
            mean_A_ -= std::expm1(-duration_s / kTime_s) * (current_A - mean_A_);
        }
    }

    /// Whether there is any, from 0 to 1.
    [[nodiscard]] double is_held() const noexcept {
        return std::clamp(mean_A_.norm() / kNone_A - 1.0, 0.0, 1.0);
    }

    /// Whether a motor carries some of it, from 0 to 1.
    [[nodiscard]] double load(Eigen::Index motor) const noexcept {
        constexpr double kPart = 0.1;
        return std::min(1.0,
                        std::abs(mean_A_[motor]) / (kPart * std::max(mean_A_.norm(), kNone_A)));
    }

private:
    static constexpr double kNone_A = 0.05; ///< offsets that are not known yet

    Vector3 mean_A_{Vector3::Zero()};
};

/// What of a motor's trim [V], along i*, is used with this i*. RT-safe.
[[nodiscard]] inline double used_trim_V(const device::MotorParameters &motor, double trim_V,
                                        double spring_A) noexcept {
    constexpr double kSlope = 3.0;
    const double limit_V =
        std::min(kSlope * motor.resistance_Ohm * std::abs(spring_A), motor.max_brush_voltage_V);
    return limit_V > 0.0 && std::isfinite(trim_V) ? std::clamp(trim_V, -limit_V, limit_V) : 0.0;
}

/// The trim after an interval. RT-safe.
/// @param trim_V    as it was used, along i*
/// @param spring_A  i*, of which only the sign counts
/// @param share     of v that is made up for
[[nodiscard]] inline double next_trim_V(const device::MotorParameters &motor,
                                        const ObservedMotor &known, const DrivenInterval &interval,
                                        double trim_V, double spring_A, double share) noexcept {
    const double T = interval.duration_s;
    const double dR_Ohm = known.here.resistance_Ohm - interval.R_hat_Ohm;
    const double mean_A = mean_current_A(interval, dR_Ohm, motor.inductance_H) - known.offset_A;
    // The limiter takes R̂ times the sensor's offset off e_W.
    const double v_V =
        interval.e_W_V + interval.R_hat_Ohm * known.offset_A - dR_Ohm * mean_A -
        (known.torque_constant_Nm_per_A * (interval.after_rad - interval.before_rad) +
         motor.inductance_H * (interval.after_A - interval.before_A)) /
            T;
    return trim_V -
           std::expm1(-kTrimRate_per_s * T) * (share * std::copysign(1.0, spring_A) * v_V - trim_V);
}

} // namespace springdrive::control
