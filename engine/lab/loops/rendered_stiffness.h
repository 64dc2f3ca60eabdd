// The coupling K_θ between one rotor and a locked set-point, over frequency (Fig. 2).
//
// The paper writes K_θ = τ/θ, which is negative at rest: the motor pushes back. Here every
// stiffness is −τ/θ, as the hand experiences it: a spring has phase 0°, a damper +90°, a mass
// ±180°.
#pragma once

#include "device/core/motor/motor.h"
#include "engine/control/tuning.h"
#include "engine/lab/loops/linear_loop.h"

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

} // namespace springdrive::loops
