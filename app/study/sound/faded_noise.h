// Pink noise with a soft start and end.
#pragma once

#include "app/study/sound/pink_noise.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <span>

namespace springdrive::app {

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

} // namespace springdrive::app
