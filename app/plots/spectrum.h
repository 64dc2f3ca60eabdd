// The spectrum of an evenly sampled signal, by Welch's method: the mean is removed, segments that
// overlap by half are weighted with a Hann window, and the powers of their transforms are averaged.
//
// A sine and noise need different scales: a longer segment leaves the amplitude of a sine as it is,
// but spreads noise over more bins. So there are two readings of one spectrum:
//
//   amplitude         A sine shows its amplitude in its bin and half of it in both neighbours.
//                     Between two bins, the nearer one shows up to 1.42 dB less: a factor of 0.849.
//   density_per_rtHz  White noise of standard deviation σ shows σ √(2/sample rate), whatever the
//                     length. Σ density² bin_Hz is the variance, of sines too.
//
// Noise also reads as an amplitude: except at both ends, density √(2 resolution_Hz).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace springdrive::signals {

/// One-sided: bin i is at i · bin_Hz, the last one at half the sample rate. All empty or 0 if there
/// are too few samples.
struct Spectrum {
    double bin_Hz = 0.0;
    std::vector<double> amplitude;        ///< of a sine, in the signal's unit
    std::vector<double> density_per_rtHz; ///< root of the power spectral density [unit/√Hz]
    std::size_t segments = 0;             ///< averaged; the spread of noise falls with their number
    double resolution_Hz = 0.0;           ///< noise bandwidth of a bin: 1.5 bins
};

/// Uses the longest run of finite values, the first of several: all others are gaps. Segments are
/// the longest power of two of which 8 fit into it, but not shorter than 64 samples: fewer than 8
/// segments from less than 288 samples, none from less than 64. Up to half a segment at the end is
/// left out. The mean is that of the run, so that drift from segment to segment stays visible in
/// the lowest bins. @pre sample_rate_hz > 0
[[nodiscard]] Spectrum amplitude_spectrum(std::span<const double> values, double sample_rate_hz);

} // namespace springdrive::signals
