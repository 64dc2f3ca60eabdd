#include "app/plots/spectrum.h"

#include "base/assertions.h"

#include <Eigen/Core>
#include <unsupported/Eigen/FFT>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace springdrive::signals {

namespace {

constexpr std::size_t kMinSegment = 64;

// Of the periodic Hann window: mean 1/2, mean square 3/8. Their ratio (3/8)/(1/2)² is the noise
// bandwidth.
constexpr double kWindowMean = 0.5;
constexpr double kNoiseBandwidthBins = 1.5;

std::span<const double> longest_finite_run(std::span<const double> values) {
    const auto is_finite = [](double value) { return std::isfinite(value); };
    std::span<const double> longest;
    auto begin = values.begin();
    while (begin != values.end()) {
        const auto end = std::find_if_not(begin, values.end(), is_finite);
        const std::span<const double> run(begin, end);
        longest = run.size() > longest.size() ? run : longest;
        begin = std::find_if(end, values.end(), is_finite);
    }
    return longest;
}

/// 8 segments that overlap by half are 4 1/2 segments long.
std::size_t segment_length(std::size_t samples) {
    return std::max(std::bit_floor(2 * samples / 9), kMinSegment);
}

std::size_t segment_count(std::size_t samples, std::size_t length) {
    return (samples - length) / (length / 2) + 1;
}

Eigen::ArrayXd hann_window(Eigen::Index length) {
    const double turn_rad = 2.0 * std::numbers::pi / static_cast<double>(length);
    return Eigen::ArrayXd::NullaryExpr(length, [turn_rad](Eigen::Index i) {
        return 0.5 - 0.5 * std::cos(turn_rad * static_cast<double>(i));
    });
}

/// The mean of |X|² over segments, for the bins from 0 to half the sample rate.
Eigen::ArrayXd mean_power(const Eigen::ArrayXd &values, Eigen::Index length, std::size_t segments) {
    const Eigen::ArrayXd window = hann_window(length);
    Eigen::FFT<double> fft;
    fft.SetFlag(fft.HalfSpectrum);
    Eigen::VectorXcd transform;
    Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(length / 2 + 1);
    for (std::size_t i = 0; i < segments; ++i) {
        const Eigen::Index start = static_cast<Eigen::Index>(i) * (length / 2);
        const Eigen::VectorXd windowed = window * values.segment(start, length);
        fft.fwd(transform, windowed);
        sum += transform.array().abs2();
    }
    return sum / static_cast<double>(segments);
}

/// 2 for a bin, which stands for ±f; 1 at both ends, where the two are one.
Eigen::ArrayXd sides(Eigen::Index bins) {
    Eigen::ArrayXd counts = Eigen::ArrayXd::Constant(bins, 2.0);
    counts[0] = 1.0;
    counts[bins - 1] = 1.0;
    return counts;
}

} // namespace

Spectrum amplitude_spectrum(std::span<const double> values, double sample_rate_hz) {
    SPRINGDRIVE_ASSERT(sample_rate_hz > 0.0);
    const std::span<const double> run = longest_finite_run(values);
    if (run.size() < kMinSegment) {
        return {};
    }
    // A copy: in place, the order of Eigen's sums depends on the alignment.
    Eigen::ArrayXd signal =
        Eigen::Map<const Eigen::ArrayXd>(run.data(), static_cast<Eigen::Index>(run.size()));
    signal -= signal.mean();
    const std::size_t length = segment_length(run.size());
    const std::size_t segments = segment_count(run.size(), length);
    const double bin_Hz = sample_rate_hz / static_cast<double>(length);
    const double resolution_Hz = kNoiseBandwidthBins * bin_Hz;

    // The two sides of a sine add up as amplitudes, those of noise as powers.
    const Eigen::ArrayXd power = mean_power(signal, static_cast<Eigen::Index>(length), segments);
    const Eigen::ArrayXd one_side = power.sqrt() / (kWindowMean * static_cast<double>(length));
    const Eigen::ArrayXd amplitude = sides(power.size()) * one_side;
    const Eigen::ArrayXd density = (sides(power.size()) / resolution_Hz).sqrt() * one_side;
    return {.bin_Hz = bin_Hz,
            .amplitude = {amplitude.begin(), amplitude.end()},
            .density_per_rtHz = {density.begin(), density.end()},
            .segments = segments,
            .resolution_Hz = resolution_Hz};
}

} // namespace springdrive::signals
