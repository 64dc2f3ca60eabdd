// Steady pink noise from the system's sound output, so that a device is not heard.
//
// It is generated as it is played, on the sound system's own thread, and knows nothing of trials:
// it begins and ends with the object, softly, and is the same in every session.
//
// Pink noise: its power density falls with 1/f, so that every octave has the same power; and the
// same with a soft start and end.
//
// A sum of Ornstein-Uhlenbeck processes of equal variance whose rates are a geometric series has
// Σ λ_k/(λ_k² + ω²), which is 1/ω but for a ripple of 2/cosh(π²/ln r), with r the ratio of the
// rates (van der Ziel 1950; the ripple by Poisson's sum formula): 0.3 % for r = 4. Sampled, each is
// x[n] = a x[n−1] + √(1 − a²) w[n], a = e^(−λT), of variance 1 exactly, so that the level is exact,
// too. The rates below keep the sampled sum within 0.11 dB of −3.01 dB an octave from 30 Hz to
// 10 kHz, at 44.1 and 48 kHz.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numbers>
#include <span>
#include <string>

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

    /// Fills with the next samples, clipped to ±1: at most a share of erfc(1/(σ√2)), that of a
    /// normal noise. 4.6 % at −6 dBFS, 0.007 % at −12, one in 10¹⁷ at −18.6.
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

/// The gain rises and falls with (1 − cos)/2, whose slope has no step: no click. RT-safe.
class FadedNoise {
public:
    FadedNoise(double sample_rate_Hz, double level_dBFS, double fade_s)
        : noise_(sample_rate_Hz, level_dBFS), step_(1.0 / (fade_s * sample_rate_Hz)) {}

    /// From any thread: from now on it falls silent.
    void end() noexcept { is_ending_.store(true, std::memory_order_relaxed); }

    void fill(std::span<float> samples) noexcept {
        noise_.fill(samples);
        const bool is_ending = is_ending_.load(std::memory_order_relaxed);
        for (float &sample : samples) {
            faded_in_ = std::clamp(faded_in_ + (is_ending ? -step_ : step_), 0.0, 1.0);
            const double gain = 0.5 - 0.5 * std::cos(std::numbers::pi * faded_in_);
            sample = static_cast<float>(gain * static_cast<double>(sample));
        }
    }

private:
    PinkNoise noise_;
    double step_ = 0.0;     ///< a sample's share of the fade
    double faded_in_ = 0.0; ///< 0 silent, 1 as loud as it gets
    std::atomic<bool> is_ending_{false};
};

/// A claim on the sound output. For one thread.
class MaskingNoise {
public:
    static constexpr std::chrono::milliseconds kFade{500}; ///< of start and end

    /// Begins to play, on the default output.
    /// @param level_dBFS  RMS of full scale, as `study::MaskingNoise::level_dBFS`
    /// @throw InputError if there is no sound output or it cannot be opened, with what to do
    explicit MaskingNoise(double level_dBFS);
    /// Fades out, which takes `kFade`, and closes the output.
    ~MaskingNoise();
    MaskingNoise(MaskingNoise &&) noexcept;
    MaskingNoise &operator=(MaskingNoise &&) noexcept;

    /// Name of the output, as the sound system gives it.
    [[nodiscard]] std::string device() const;

    /// Whether sound has been asked for within the last half second: false after the output was
    /// lost, or the sound system has stopped.
    [[nodiscard]] bool is_playing() const;

    /// Gaps so far, where the system did not ask in time: a click each.
    [[nodiscard]] int underruns() const;

private:
    struct Output;
    std::unique_ptr<Output> output_;
};

} // namespace springdrive::app
