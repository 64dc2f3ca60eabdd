// The coupling K_θ measured by a sine sweep on the simulated motor, with the predictions of (12)
// and of the sampled form.
#pragma once

#include "base/table.h"
#include "engine/lab/loops/rendered_stiffness.h"

#include <complex>
#include <vector>

namespace springdrive::loops {

/// The motion of a rotor held in a vice while its torque is measured.
struct SweepOptions {
    double amplitude_rad = 0.1;       ///< A of θ(t) = A sin ωt; matters with an encoder only
    double encoder_quantum_rad = 0.0; ///< of the servo's θ; 0: exact
};

struct StiffnessPoint {
    double frequency_hz = 0.0;                ///< the one that was used, see `sweep_window`
    std::complex<double> analytic_Nm_per_rad; ///< (12)
    std::complex<double> sampled_Nm_per_rad;  ///< docs/design.md, "Sampled forms"
    std::complex<double> measured_Nm_per_rad; ///< −τ/θ like the others, see rendered_stiffness.h
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
