#include "app/study/sound/pink_noise.h"

#include "base/split_mix.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::app {

PinkNoise::PinkNoise(double sample_rate_Hz, double level_dBFS) {
    const double deviation =
        std::pow(10.0, level_dBFS / 20.0) / std::sqrt(static_cast<double>(kProcesses));
    double rate_Hz = kFastest_Hz;
    for (Process &process : processes_) {
        process.keep = std::exp(-2.0 * std::numbers::pi * rate_Hz / sample_rate_Hz);
        process.renew = deviation * std::sqrt(1.0 - process.keep * process.keep);
        rate_Hz /= kRatio;
    }
    // The slowest takes a second to reach its variance from nothing; so each begins as it will be.
    for (Process &process : processes_) {
        double sum = 0.0; // of twelve uniform draws: near enough to normal for one value
        for (int i = 0; i < 12; ++i) {
            sum += split_mix::unit_share(split_mix::value(0, draws_++)) - 0.5;
        }
        process.value = deviation * sum;
    }
}

double PinkNoise::next() noexcept {
    double sum = 0.0;
    for (Process &process : processes_) {
        const double uniform = split_mix::unit_share(split_mix::value(0, draws_++)) - 0.5;
        const double unit = uniform * (2.0 * std::numbers::sqrt3); // variance 1
        process.value = process.keep * process.value + process.renew * unit;
        sum += process.value;
    }
    return sum;
}

void PinkNoise::fill(std::span<float> samples) noexcept {
    for (float &sample : samples) {
        sample = static_cast<float>(std::clamp(next(), -1.0, 1.0));
    }
}

} // namespace springdrive::app
