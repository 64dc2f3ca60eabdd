// Covers app/study/sound/pink_noise.cpp and faded_noise.h: level, spectrum, clipping and fades
// against theory.
#include "app/study/sound/faded_noise.h"
#include "app/study/sound/pink_noise.h"

#include "base/split_mix.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

namespace springdrive::app {
namespace {

constexpr double kRate_Hz = 48'000.0;

std::vector<double> pink(double level_dBFS, std::size_t count, double rate_Hz = kRate_Hz) {
    PinkNoise noise(rate_Hz, level_dBFS);
    std::vector<double> samples(count);
    for (double &sample : samples) {
        sample = noise.next();
    }
    return samples;
}

double mean_square(const std::vector<double> &samples) {
    double sum = 0.0;
    for (const double sample : samples) {
        sum += sample * sample;
    }
    return sum / static_cast<double>(samples.size());
}

/// Relative standard error of the mean square over a time: √(2/T ∫ρ²), ρ the mean of e^(−λ_k|s|).
double error_of_mean_square(double time_s) {
    double integral_s = 0.0;
    const auto rate = [](std::size_t i) {
        return 2.0 * std::numbers::pi * PinkNoise::kFastest_Hz *
               std::pow(PinkNoise::kRatio, -static_cast<double>(i));
    };
    for (std::size_t i = 0; i < PinkNoise::kProcesses; ++i) {
        for (std::size_t j = 0; j < PinkNoise::kProcesses; ++j) {
            integral_s += 2.0 / (rate(i) + rate(j));
        }
    }
    constexpr auto kPairs = static_cast<double>(PinkNoise::kProcesses * PinkNoise::kProcesses);
    return std::sqrt(2.0 * integral_s / kPairs / time_s);
}

TEST(PinkNoise, HasTheLevelAskedFor) {
    constexpr std::size_t kSeconds = 60;
    for (const double level_dBFS : {-6.0, -30.0, -80.0}) {
        const double wanted = std::pow(10.0, level_dBFS / 10.0);
        const double found =
            mean_square(pink(level_dBFS, kSeconds * static_cast<std::size_t>(kRate_Hz)));
        const double error = error_of_mean_square(static_cast<double>(kSeconds));
        EXPECT_LT(error, 0.011) << "the test can see 0.05 dB";
        EXPECT_NEAR(found / wanted, 1.0, 4.0 * error) << level_dBFS;
    }
}

using Spectrum = std::vector<std::complex<double>>;

constexpr std::size_t kSegment = 16'384;
constexpr std::size_t kSegments = 256;

/// e^(−2πi n/kSegment) for the first half of a turn.
const Spectrum &turns() {
    static const Spectrum all = [] {
        Spectrum one(kSegment / 2);
        for (std::size_t i = 0; i < one.size(); ++i) {
            one[i] = std::polar(1.0, -2.0 * std::numbers::pi * static_cast<double>(i) /
                                         static_cast<double>(kSegment));
        }
        return one;
    }();
    return all;
}

/// Cooley and Tukey 1965, for lengths that divide kSegment.
void transform(Spectrum &values) {
    const std::size_t half = values.size() / 2;
    if (half == 0) {
        return;
    }
    Spectrum even(half);
    Spectrum odd(half);
    for (std::size_t i = 0; i < half; ++i) {
        even[i] = values[2 * i];
        odd[i] = values[2 * i + 1];
    }
    transform(even);
    transform(odd);
    const std::size_t stride = kSegment / values.size();
    for (std::size_t i = 0; i < half; ++i) {
        const std::complex<double> turned = turns()[i * stride] * odd[i];
        values[i] = even[i] + turned;
        values[i + half] = even[i] - turned;
    }
}

/// Power at each multiple of rate/kSegment, averaged over segments with Hann's window (Welch 1967).
std::vector<double> power(const std::vector<double> &samples) {
    std::vector<double> sum(kSegment / 2);
    for (std::size_t from = 0; from + kSegment <= samples.size(); from += kSegment) {
        Spectrum segment(kSegment);
        for (std::size_t i = 0; i < kSegment; ++i) {
            const double turn = static_cast<double>(i) / static_cast<double>(kSegment);
            segment[i] = samples[from + i] * (1.0 - std::cos(2.0 * std::numbers::pi * turn));
        }
        transform(segment);
        for (std::size_t i = 0; i < sum.size(); ++i) {
            sum[i] += std::norm(segment[i]);
        }
    }
    return sum;
}

struct Octave {
    double middle_Hz = 0.0;
    double level_dB = 0.0; ///< of power density times frequency: the same in each for pink noise
    double error_dB = 0.0; ///< standard error
};

std::vector<Octave> octaves(const std::vector<double> &samples, double rate_Hz) {
    const std::vector<double> density = power(samples);
    const double step_Hz = rate_Hz / static_cast<double>(kSegment);
    std::vector<Octave> all;
    constexpr double kTo_Hz = 10'000.0;
    constexpr int kOctaves = 8;
    const double width = std::log2(kTo_Hz / 30.0) / kOctaves; // 1.05 octaves
    for (int octave = 0; octave < kOctaves; ++octave) {
        const double from_Hz = 30.0 * std::exp2(width * octave);
        double sum = 0.0;
        int count = 0;
        for (std::size_t i = 1; i < density.size(); ++i) {
            const double at_Hz = step_Hz * static_cast<double>(i);
            if (at_Hz >= from_Hz && at_Hz < from_Hz * std::exp2(width)) {
                sum += density[i] * at_Hz;
                ++count;
            }
        }
        // Each bin of each segment is of an exponential distribution; with Hann's window
        // neighbours share a good half, so that there are 18/35 independent ones.
        const double independent = count * static_cast<double>(kSegments) * 18.0 / 35.0;
        all.push_back({from_Hz * std::exp2(width / 2.0), 10.0 * std::log10(sum / count),
                       10.0 / std::numbers::ln10 / std::sqrt(independent)});
    }
    return all;
}

/// By least squares [dB per octave], of power density.
double slope_dB(const std::vector<Octave> &all) {
    double sum_x = 0.0;
    double sum_y = 0.0;
    double sum_xx = 0.0;
    double sum_xy = 0.0;
    for (const Octave &one : all) {
        const double x = std::log2(one.middle_Hz);
        sum_x += x;
        sum_y += one.level_dB;
        sum_xx += x * x;
        sum_xy += x * one.level_dB;
    }
    const auto n = static_cast<double>(all.size());
    const double of_product = (n * sum_xy - sum_x * sum_y) / (n * sum_xx - sum_x * sum_x);
    return of_product - 10.0 * std::log10(2.0);
}

TEST(PinkNoise, FallsByThreeDecibelsAnOctave) {
    for (const double rate_Hz : {44'100.0, 48'000.0}) {
        const std::vector<Octave> all =
            octaves(pink(-30.0, kSegment * kSegments, rate_Hz), rate_Hz);
        double mean_dB = 0.0;
        for (const Octave &one : all) {
            mean_dB += one.level_dB / static_cast<double>(all.size());
        }
        for (const Octave &one : all) {
            EXPECT_LT(one.error_dB, 0.15);
            // 0.11 dB: the ripple that the header states. 0.04 dB: the window's width at 30 Hz.
            EXPECT_NEAR(one.level_dB, mean_dB, 0.15 + 4.0 * one.error_dB)
                << one.middle_Hz << " Hz at " << rate_Hz;
        }
        EXPECT_NEAR(slope_dB(all), -3.01, 0.05) << rate_Hz;
    }
}

/// The other side: the measure sees another spectrum.
TEST(PinkNoise, IsNotWhite) {
    std::vector<double> white(kSegment * kSegments);
    std::uint64_t draw = 0;
    for (double &sample : white) {
        sample = split_mix::unit_share(split_mix::value(1, draw++)) - 0.5;
    }
    EXPECT_NEAR(slope_dB(octaves(white, kRate_Hz)), 0.0, 0.05);
}

TEST(PinkNoise, IsClippedAsSeldomAsIsStated) {
    constexpr std::size_t kSamples = 2'000'000;
    struct Case {
        double level_dBFS;
        double stated;    ///< erfc(1/(σ√2)), by another program
        double deviation; ///< of the share that is found, relative; roughly, as clips come in runs
    };
    for (const Case &one :
         {Case{-6.0, 0.046014, 0.03}, Case{-12.0, 6.8605e-5, 0.2}, Case{-30.0, 1.7958e-219, 0.0}}) {
        EXPECT_NEAR(clipped_share(one.level_dBFS), one.stated, 1e-4 * one.stated);
        PinkNoise noise(kRate_Hz, one.level_dBFS);
        std::vector<float> samples(kSamples);
        noise.fill(samples);
        std::size_t clipped = 0;
        for (const float sample : samples) {
            ASSERT_LE(std::abs(sample), 1.0F);
            clipped += std::abs(sample) == 1.0F ? 1 : 0;
        }
        const double share = static_cast<double>(clipped) / static_cast<double>(kSamples);
        EXPECT_LE(share, one.stated * (1.0 + 3.0 * one.deviation)) << one.level_dBFS;
        if (one.stated * static_cast<double>(kSamples) > 1.0) {
            EXPECT_GE(share, one.stated * (0.8 - 3.0 * one.deviation)) << one.level_dBFS;
        }
    }
}

TEST(PinkNoise, IsTheSameEachTime) {
    const std::vector<double> samples = pink(-30.0, 1000);
    EXPECT_EQ(samples, pink(-30.0, 1000));
    const std::vector<double> louder = pink(-10.0, 1000);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        EXPECT_NEAR(louder[i], 10.0 * samples[i], 1e-12);
    }
}

TEST(FadedNoise, BeginsAndEndsWithoutAClick) {
    constexpr double kFade_s = 0.5;
    constexpr std::size_t kFade = 24'000; // samples
    FadedNoise faded(kRate_Hz, -30.0, kFade_s);
    PinkNoise noise(kRate_Hz, -30.0);
    const auto expect_gain = [&](std::size_t count, const auto &gain) {
        std::vector<float> plain(count);
        std::vector<float> samples(count);
        noise.fill(plain);
        faded.fill(samples);
        for (std::size_t i = 0; i < count; ++i) {
            const double wanted = gain(i) * static_cast<double>(plain[i]);
            ASSERT_NEAR(static_cast<double>(samples[i]), wanted, 1e-6) << i;
        }
    };
    const auto risen = [](double share) {
        return (1.0 - std::cos(std::numbers::pi * share)) / 2.0;
    };
    expect_gain(kFade, [&](std::size_t i) { return risen(double(i + 1) / double(kFade)); });
    expect_gain(1000, [](std::size_t) { return 1.0; });
    faded.end();
    expect_gain(kFade, [&](std::size_t i) { return risen(1.0 - double(i + 1) / double(kFade)); });
    expect_gain(1000, [](std::size_t) { return 0.0; });
}

} // namespace
} // namespace springdrive::app
