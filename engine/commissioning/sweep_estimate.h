// The rendered stiffness from amplitudes measured under excitation.
//
// The servo is software: its share of e_W for a motion is known. What is not known is the amplifier
// with its winding, on which e_W and the back-EMF act alike (1), (6):
//
//   I = Y(jω) [ H(jω) E − k_T jω Θ ],     H(jω) = e^(−jωdT) (1 − e^(−jωT))/(jωT)
//
// With a locked set-point and no excitation E = −C(e^(jωT)) Θ (docs/design.md, "Sampled forms"), so
// that the stiffness is
//
//   K_θ = −k_T I/Θ = k_T Y [ C H + k_T jω ]
//
// whatever moved the rotor while Y was measured. Y contains dR, L, the amplifier's loop and the
// gains of its sensors and stages; k_T follows from the back-EMF of the whole sweep. T and d are
// taken as known, and that the torque is k_T times the current that the sensor reads.
//
// I and Θ are sampled once in a period, while currents and rotor also move with each step of e_W:
// those aliases are some per cent near a tenth of the servo rate. They follow from the winding, dR
// and L, and the inertia that fit the whole sweep of a motor.
#pragma once

#include "engine/lab/loops/rendered_stiffness.h"

#include <Eigen/Core>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

namespace springdrive::commissioning {

/// Of e^(jωt).
struct BlockAmplitudes {
    std::complex<double> excitation_V;
    std::complex<double> e_W_V; ///< as passed to the amplifier, excitation included
    std::complex<double> current_A;
    std::complex<double> theta_rad;
};

/// What belongs to one tick.
struct BlockSample {
    double time_s = 0.0; ///< of the measurement
    double excitation_V = 0.0;
    double e_W_V = 0.0;
    double current_A = 0.0;
    double theta_rad = 0.0;
};

/// The complex amplitudes of what was measured at one frequency, by least squares at the device's
/// own measurement times: beside the sine, a constant, a drift, and a slow dither of known
/// frequency.
class SweepBlock {
public:
    SweepBlock() = default;

    /// @param dither_rad_per_s  0: none
    SweepBlock(double omega_rad_per_s, double dither_rad_per_s, double duration_s)
        : omega_rad_per_s_(omega_rad_per_s), dither_rad_per_s_(dither_rad_per_s),
          duration_s_(duration_s) {}

    void take(const BlockSample &sample) noexcept;

    /// @pre  more ticks were taken than the sine has unknowns, over at least one period
    [[nodiscard]] BlockAmplitudes amplitudes() const;

private:
    static constexpr int kRegressors = 6; ///< 1, t, sine and dither
    static constexpr int kSignals = 4;

    double omega_rad_per_s_ = 0.0;
    double dither_rad_per_s_ = 0.0;
    double duration_s_ = 1.0;
    Eigen::Matrix<double, kRegressors, kRegressors> normal_ =
        Eigen::Matrix<double, kRegressors, kRegressors>::Zero();
    Eigen::Matrix<double, kRegressors, kSignals> products_ =
        Eigen::Matrix<double, kRegressors, kSignals>::Zero();
};

/// What was measured at one frequency.
struct SweepMeasurement {
    std::size_t motor = 0;
    double frequency_hz = 0.0;
    std::vector<BlockAmplitudes> blocks; ///< at least one
    double delay_periods = 0.0;
    double torque_constant_Nm_per_A = 0.0; ///< for which the law computed e_W
    double cancelled_Ohm = 0.0;            ///< R̂, which follows R while it is observed
    double excitation_V = 0.0;             ///< its amplitude

    [[nodiscard]] double omega_rad_per_s() const;
};

/// A winding with its amplifier and its rotor, as far as a resistance, an inductance and an inertia
/// describe them.
struct FittedWinding {
    double dR_Ohm = 0.0;        ///< beside this R̂; by as much less as another one is more
    double cancelled_Ohm = 0.0; ///< mean over the sweep
    double inductance_H = 0.0;
    double torque_constant_Nm_per_A = 0.0; ///< by the back-EMF
    double inertia_kg_m2 = 0.0; ///< of the rotor, with what moves with it above its resonances
};

/// A point of a larger deviation is not known well enough.
inline constexpr double kUncertain = 0.01;

/// One frequency's result.
struct SweepPoint {
    double frequency_hz = 0.0;
    std::complex<double> measured_Nm_per_rad;
    double deviation = 0.0; ///< standard deviation of it, as a share of its magnitude
    std::complex<double> sampled_Nm_per_rad;  ///< with the measured d
    std::complex<double> analytic_Nm_per_rad; ///< (12)
    double delay_periods = 0.0;
    double excitation_V = 0.0;

    /// By which the magnitude exceeds that of the sampled form, as a share of it.
    [[nodiscard]] double magnitude_error() const;
    /// By which the phase exceeds that of the sampled form [rad].
    [[nodiscard]] double phase_error_rad() const;
};

/// A motor's sweep.
struct MotorSweep {
    std::size_t motor = 0;
    FittedWinding winding;
    std::vector<SweepPoint> points; ///< by rising frequency
};

/// @param drive  the prediction: the file's motor, tuning and T; d is that of each measurement
/// @param measurements  of one motor, at least one
[[nodiscard]] MotorSweep estimate_sweep(const loops::SpringDrive &drive,
                                        std::span<const SweepMeasurement> measurements);

/// The deviation alone, for a winding as predicted.
[[nodiscard]] double estimated_deviation(const loops::SpringDrive &drive,
                                         const SweepMeasurement &measurement);

} // namespace springdrive::commissioning
