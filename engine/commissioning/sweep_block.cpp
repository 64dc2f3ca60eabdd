#include "engine/commissioning/sweep_block.h"

#include <Eigen/Cholesky>

#include <cmath>

namespace springdrive::commissioning {

void SweepBlock::take(const BlockSample &sample) noexcept {
    const double phase = omega_rad_per_s_ * sample.time_s;
    const double dither = dither_rad_per_s_ * sample.time_s;
    const bool has_dither = dither_rad_per_s_ > 0.0;
    Eigen::Matrix<double, kRegressors, 1> regressor;
    regressor << 1.0, 2.0 * sample.time_s / duration_s_ - 1.0, std::cos(phase), std::sin(phase),
        has_dither ? std::cos(dither) : 0.0, has_dither ? std::sin(dither) : 0.0;
    normal_ += regressor * regressor.transpose();
    products_ += regressor * Eigen::Matrix<double, 1, kSignals>(sample.excitation_V, sample.e_W_V,
                                                                sample.current_A, sample.theta_rad);
}

BlockAmplitudes SweepBlock::amplitudes() const {
    Eigen::Matrix<double, kRegressors, kRegressors> normal = normal_;
    if (dither_rad_per_s_ <= 0.0) { // the last two are not in use
        normal(4, 4) = normal(5, 5) = 1.0;
    }
    const Eigen::Matrix<double, kRegressors, kSignals> found = normal.ldlt().solve(products_);
    const auto amplitude = [&](int signal) {
        // c cos ωt + s sin ωt = Re[(c − j s) e^(jωt)]
        return std::complex<double>(found(2, signal), -found(3, signal));
    };
    return {amplitude(0), amplitude(1), amplitude(2), amplitude(3)};
}

} // namespace springdrive::commissioning
