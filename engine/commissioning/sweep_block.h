// The complex amplitudes of what was measured at one frequency, by least squares at the device's
// own measurement times: beside the sine, a constant, a drift, and a slow dither of known
// frequency.
#pragma once

#include <Eigen/Core>

#include <complex>

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

} // namespace springdrive::commissioning
