// Covers app/study/sound/masking_noise.cpp: level, spectrum, clipping and fades
// against theory; what the system's sound output is given, by an output of ALSA that writes to a
// file; and what is said where there is none.
#include "app/study/sound/masking_noise.h"
#include "base/input_error.h"
#include "base/split_mix.h"
#include "tests/support/files.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <unsupported/Eigen/FFT>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <string>
#include <thread>
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
        const double requested = std::pow(10.0, level_dBFS / 10.0);
        const double found =
            mean_square(pink(level_dBFS, kSeconds * static_cast<std::size_t>(kRate_Hz)));
        const double error = error_of_mean_square(static_cast<double>(kSeconds));
        EXPECT_LT(error, 0.011) << "the test can see 0.05 dB";
        EXPECT_NEAR(found / requested, 1.0, 4.0 * error) << level_dBFS;
    }
}

constexpr std::size_t kSegment = 16'384;
constexpr std::size_t kSegments = 256;

/// Power at each multiple of rate/kSegment, averaged over segments with Hann's window (Welch 1967).
std::vector<double> power(const std::vector<double> &samples) {
    Eigen::FFT<double> transform;
    std::vector<double> sum(kSegment / 2);
    std::vector<double> segment(kSegment);
    std::vector<std::complex<double>> spectrum;
    for (std::size_t from = 0; from + kSegment <= samples.size(); from += kSegment) {
        for (std::size_t i = 0; i < kSegment; ++i) {
            const double turn = static_cast<double>(i) / static_cast<double>(kSegment);
            segment[i] = samples[from + i] * (1.0 - std::cos(2.0 * std::numbers::pi * turn));
        }
        transform.fwd(spectrum, segment);
        for (std::size_t i = 0; i < sum.size(); ++i) {
            sum[i] += std::norm(spectrum[i]);
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
    // The measure sees another spectrum.
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
            const double requested = gain(i) * static_cast<double>(plain[i]);
            ASSERT_NEAR(static_cast<double>(samples[i]), requested, 1e-6) << i;
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

/// What is said, also by the libraries below, in a process that is prepared for it.
std::string in_child(const std::function<void()> &prepare,
                     const std::function<std::string()> &step) {
    return testing::said_in_child(prepare, [&step] {
        ::testing::internal::CaptureStderr();
        std::string said;
        try {
            said = step();
        } catch (const InputError &error) {
            said = error.what();
        }
        return said + ::testing::internal::GetCapturedStderr();
    });
}

TEST(MaskingNoise, WithoutASoundOutputSaysSoInALine) {
    const std::string said = in_child([] {},
                                      [] {
                                          const MaskingNoise noise(-80.0);
                                          return std::string("plays");
                                      });
    if (said == "plays") {
        GTEST_SKIP() << "this machine has a sound output";
    }
    EXPECT_EQ(said,
              "masking noise: there is no sound output; plug in headphones and choose them as "
              "the system's sound output, or give --without-noise, which plays none");
}

constexpr const char *kSystems = "/usr/share/alsa/alsa.conf"; ///< of the package libasound2-data

TEST(MaskingNoise, PlaysSoftlyBegunAndEndedAtItsLevel) {
    if (!std::filesystem::exists(kSystems)) {
        GTEST_SKIP() << kSystems << " is not there";
    }
    constexpr double kLevel_dBFS = -40.0;
    const std::filesystem::path folder = testing::fresh_folder("sound");
    const std::filesystem::path raw = folder / "played.raw";
    const std::filesystem::path configuration = folder / "asound.conf";
    std::ofstream(configuration) << fmt::format(
        "<{}>\npcm.!default {{ type file slave.pcm \"null\" file \"{}\" format "
        "\"raw\" }}\n",
        kSystems, raw.string());
    const std::string said =
        in_child([&] { setenv("ALSA_CONFIG_PATH", configuration.c_str(), 1); },
                 [] {
                     MaskingNoise noise(kLevel_dBFS);
                     std::this_thread::sleep_for(std::chrono::milliseconds(200));
                     const MaskingNoise moved(std::move(noise));
                     return moved.device() + (moved.is_playing() ? " plays" : " is silent");
                 });
    ASSERT_EQ(said, "default plays");
    const std::string bytes = testing::contents_of(raw);
    std::vector<float> samples(bytes.size() / sizeof(float)); // left and right
    std::memcpy(samples.data(), bytes.data(), samples.size() * sizeof(float));
    // That output takes sound as fast as it is made: many seconds in these 0.2, and silence while
    // the fade is waited for.
    while (!samples.empty() && samples.back() == 0.0F) {
        samples.pop_back();
    }
    constexpr std::size_t kFade = 48'000; // half a second of two channels at 48 kHz
    ASSERT_GT(samples.size(), 4 * kFade);
    double sum = 0.0;
    double loudest = 0.0;
    const std::size_t end = samples.size() - kFade;
    for (std::size_t i = 0; i + 1 < samples.size(); i += 2) {
        ASSERT_EQ(samples[i], samples[i + 1]) << "the same in both ears";
        const auto sample = static_cast<double>(samples[i]);
        sum += i >= kFade && i < end ? 2.0 * sample * sample : 0.0;
        loudest = std::max(loudest, std::abs(sample));
    }
    const double level_dBFS = 10.0 * std::log10(sum / static_cast<double>(end - kFade));
    EXPECT_NEAR(level_dBFS, kLevel_dBFS, 1.0) << "some seconds; exactly in PinkNoise";
    // Soft at both ends: a thousandth of the amplitude and less in the first and last millisecond.
    const double amplitude = std::pow(10.0, kLevel_dBFS / 20.0);
    for (std::size_t i = 0; i < 88; ++i) {
        EXPECT_LT(std::abs(samples[i]), 1e-3 * amplitude) << i;
        EXPECT_LT(std::abs(samples[samples.size() - 1 - i]), 1e-3 * amplitude) << i;
    }
    EXPECT_GT(loudest, 2.0 * amplitude) << "and not in between";
}

} // namespace
} // namespace springdrive::app
