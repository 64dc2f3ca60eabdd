// The stiffness that a sampled law renders over frequency: the coupling K_θ between one rotor and a
// locked set-point (Fig. 2), and at the tip.
//
// The paper writes K_θ = τ/θ, which is negative at rest: the motor pushes back. Here every
// stiffness is −τ/θ, as the hand experiences it: a spring has phase 0°, a damper +90°, a mass
// ±180°.
#pragma once

#include "device/core/motor/motor.h"
#include "engine/control/tuning.h"
#include "engine/lab/loops/linear_loop.h"
#include "engine/lab/loops/stability_case.h"

#include <complex>

namespace springdrive::loops {

/// One motor behind its spring-drive amplifier, with the servo that compensates its drift.
struct SpringDrive {
    device::MotorParameters motor;
    control::Tuning
        tuning; ///< dR, K_P, K_D and λ; the set-point is locked, η and the maps do not enter
    double period_s = 1e-3;     ///< T, the servo period
    double delay_periods = 0.0; ///< d, periods from reading θ to applying e_W; not negative

    /// The dR that results from the tuning's setting [Ω].
    [[nodiscard]] double dR_Ohm() const {
        return device::residual_resistance_Ohm(motor, tuning.dR_Ohm);
    }
};

/// (12) [N·m/rad]: the servo as if it were continuous, T → 0.
///
///   K_θ(s) = k_T/(Ls + dR) · λ/(s + λ) · [ (k_T + K_D + K_P/λ) s + K_P + k_T s²/λ ],   s = jω
[[nodiscard]] std::complex<double> analytic_stiffness(const SpringDrive &drive,
                                                      double omega_rad_per_s);

/// The same with the servo's period and delay [N·m/rad], docs/design.md, "Sampled forms": the
/// component of the torque at ω, while θ oscillates at ω alone.
///
///   K_θ(jω) = k_T/(jωL + dR) · [ k_T jω + C(e^(jωT)) H(jω) ],   a = e^(−λT)
///   C(z) = K_P + K_D (1 − a)(1 − z⁻¹)/(T (1 − a z⁻¹)),   H(jω) = e^(−jωdT) (1 − e^(−jωT))/(jωT)
///
/// It is `motor_stiffness` of one motor.
[[nodiscard]] std::complex<double> sampled_stiffness(const SpringDrive &drive,
                                                     double omega_rad_per_s);

/// k_T² s/(Ls + R) [N·m/rad]: the shorted motor without resistance cancellation or servo, the
/// dotted curve of Fig. 2.
[[nodiscard]] std::complex<double> unmodified_stiffness(const device::MotorParameters &motor,
                                                        double omega_rad_per_s);

// At the tip, with either drive.

/// The part along `direction` of the force against a tip that a vice moves along it at ω, per
/// displacement [N/m]; a spring has phase 0°, a damper +90°. All motors, at the case's
/// configuration and with its η:
///
///   K_x = J⁻ᵀ K_m J⁻¹
///
/// with K_m of `motor_stiffness`; for η = 0 and one motor that is K_θ.
[[nodiscard]] std::complex<double> tip_stiffness(const StabilityCase &which,
                                                 const Vector3 &direction, double omega_rad_per_s);

/// The limit as ω goes to infinity: the inductive stiffness (14) of a spring drive, zero for a
/// current drive [N/m].
[[nodiscard]] double inductive_tip_stiffness(const StabilityCase &which, const Vector3 &direction);

/// The change of the tip's force within a period from one count of one encoder, through gains,
/// filter and winding, all else at rest: the largest of the three encoders [N]. A large value is
/// felt as a buzz.
[[nodiscard]] double force_of_a_count_N(const StabilityCase &which);

} // namespace springdrive::loops
