// The stiffness that a sampled law renders over frequency: the coupling K_θ between one rotor and a
// locked set-point (Fig. 2), predicted and measured, and at the tip.
//
// The paper writes K_θ = τ/θ, which is negative at rest: the motor pushes back. Here every
// stiffness is −τ/θ, as the hand experiences it: a spring has phase 0°, a damper +90°, a mass
// ±180°.
#pragma once

#include "base/table.h"
#include "device/core/motor/motor.h"
#include "engine/control/tuning.h"
#include "engine/lab/loops/linear_loop.h"
#include "engine/lab/loops/stability_case.h"

#include <complex>
#include <vector>

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

/// The same at rest, for a vice that moves the tip in any direction, as a hand feels it behind a
/// structure: see `felt_stiffness_N_per_m`.
[[nodiscard]] Matrix3 felt_at_rest_N_per_m(const StabilityCase &which, const Structure &structure);

/// The limit as ω goes to infinity: the inductive stiffness (14) of a spring drive, zero for a
/// current drive [N/m].
[[nodiscard]] double inductive_tip_stiffness(const StabilityCase &which, const Vector3 &direction);

/// The change of the tip's force within a period from one count of one encoder, through gains,
/// filter and winding, all else at rest: the largest of the three encoders [N]. A large value is
/// felt as a buzz.
[[nodiscard]] double force_of_a_count_N(const StabilityCase &which);

// K_θ measured by a sine sweep on the simulated motor, with the predictions of (12) and of the
// sampled form.

/// The motion of a rotor held in a vice while its torque is measured.
struct SweepOptions {
    double amplitude_rad = 0.1;       ///< A of θ(t) = A sin ωt; matters with an encoder only
    double encoder_quantum_rad = 0.0; ///< of the servo's θ; 0: exact
};

struct StiffnessPoint {
    double frequency_hz = 0.0;                ///< the one that was used, see `sweep_window`
    std::complex<double> analytic_Nm_per_rad; ///< (12)
    std::complex<double> sampled_Nm_per_rad;  ///< docs/design.md, "Sampled forms"
    std::complex<double> measured_Nm_per_rad; ///< −τ/θ like the others
};

/// A window of whole periods of the sine and whole ticks of the servo.
struct SweepWindow {
    long periods = 0;
    long ticks = 0;

    [[nodiscard]] double frequency_hz(double period_s) const {
        return static_cast<double>(periods) / (static_cast<double>(ticks) * period_s);
    }
};

/// The window of the frequency nearest to the requested one. The servo's response to a sine has
/// aliases at multiples of its rate as well; they cancel only over whole periods of both. Windows
/// are at least 1000 ticks long, so that the frequency changes by no more than 1/2000 of itself,
/// and it stays below half the servo rate, where the first alias meets the sine.
[[nodiscard]] SweepWindow sweep_window(double frequency_hz, double period_s);

/// −τ/θ at the window's frequency: τ = k_T i correlated with e^(−jωt) once the transient is below
/// 1e-6 of its initial value.
///
/// The winding is integrated exactly over sub-steps h with ωh ≤ 0.02, during which θ is linear in
/// time. That reduces the back-EMF by (ωh)²/12, and the mean current over a step is (ωh)²/24 below
/// the one at its middle: 5e-5 of each part of the torque, and more of their sum where back-EMF and
/// servo nearly cancel.
[[nodiscard]] std::complex<double> measured_stiffness(const SpringDrive &drive, SweepWindow window,
                                                      const SweepOptions &options = {});

/// The frequencies of a sweep.
struct SweepRange {
    double min_hz = 0.0;
    double max_hz = 0.0;
    int points = 0; ///< at least two, evenly spaced on a logarithmic scale
};

[[nodiscard]] std::vector<StiffnessPoint> stiffness_sweep(const SpringDrive &drive,
                                                          const SweepRange &range,
                                                          const SweepOptions &options = {});

/// A phase in degrees, −180 to 180.
[[nodiscard]] double phase_deg(const std::complex<double> &stiffness);

/// freq_hz, then magnitude [N·m/rad] and phase [deg] of each of the three.
[[nodiscard]] Table stiffness_table(const std::vector<StiffnessPoint> &points);

} // namespace springdrive::loops
