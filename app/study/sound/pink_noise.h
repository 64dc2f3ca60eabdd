// Pink noise: its power density falls with 1/f, so that every octave has the same power.
//
// A sum of Ornstein-Uhlenbeck processes of equal variance whose rates are a geometric series has
// Σ λ_k/(λ_k² + ω²), which is 1/ω but for a ripple of 2/cosh(π²/ln r), with r the ratio of the
// rates (van der Ziel 1950; the ripple by Poisson's sum formula): 0.3 % for r = 4. Sampled, each is
// x[n] = a x[n−1] + √(1 − a²) w[n], a = e^(−λT), of variance 1 exactly, so that the level is exact,
// too. The rates below keep the sampled sum within 0.11 dB of −3.01 dB an octave from 30 Hz to
// 10 kHz, at 44.1 and 48 kHz.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace springdrive::app {

/// Samples of full scale 1. RT-safe: no allocation, no lock, a bounded time per sample.
class PinkNoise {
public:
    static constexpr std::size_t kProcesses = 7;
    static constexpr double kFastest_Hz = 12'000.0; ///< rate of the fastest process, over 2π
    static constexpr double kRatio = 4.0;           ///< of each rate to the next

    /// @param level_dBFS  RMS before clipping, of full scale
    PinkNoise(double sample_rate_Hz, double level_dBFS);

    /// The next sample before clipping. A little flatter than normal, as what is
    /// drawn is uniform: excess kurtosis −0.035 at 48 kHz.
    [[nodiscard]] double next() noexcept;

    /// Fills with the next samples, clipped to ±1.
    void fill(std::span<float> samples) noexcept;

private:
    struct Process {
        double keep = 0.0;  ///< a
        double renew = 0.0; ///< √(1 − a²), times the standard deviation of its share
        double value = 0.0;
    };
    std::array<Process, kProcesses> processes_;
    std::uint64_t draws_ = 0; ///< of SplitMix64, from the same start in every program
};

/// At most this share of the samples is clipped: that of a normal noise, erfc(1/(σ√2)). 4.6 % at
/// −6 dBFS, 0.007 % at −12, one in 10¹⁷ at −18.6.
[[nodiscard]] double clipped_share(double level_dBFS);

} // namespace springdrive::app
