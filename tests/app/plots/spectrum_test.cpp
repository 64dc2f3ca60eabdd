// Covers app/plots/spectrum.cpp.
#include "app/plots/spectrum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

namespace springdrive::signals {
namespace {

using std::numbers::pi;

constexpr double kRate_Hz = 1000.0;
constexpr std::size_t kSegment = 256;
constexpr std::size_t kEightSegments = kSegment * 9 / 2;

/// A sine of `bins` whole or broken bins of `kSegment`.
std::vector<double> sine(double bins, double amplitude = 1.0, double phase_rad = 0.3) {
    std::vector<double> values;
    for (std::size_t i = 0; i < kEightSegments; ++i) {
        const double turns = bins * static_cast<double>(i) / static_cast<double>(kSegment);
        values.push_back(amplitude * std::sin(2.0 * pi * turns + phase_rad));
    }
    return values;
}

std::vector<double> sum(std::vector<double> a, const std::vector<double> &b) {
    std::transform(a.begin(), a.end(), b.begin(), a.begin(), std::plus<>());
    return a;
}

std::vector<double> white_noise(std::size_t count, double sigma, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> noise(0.0, sigma);
    std::vector<double> values(count);
    std::generate(values.begin(), values.end(), [&] { return noise(random); });
    return values;
}

double power(const Spectrum &spectrum) {
    double sum = 0.0;
    for (const double density : spectrum.density_per_rtHz) {
        sum += density * density * spectrum.bin_Hz;
    }
    return sum;
}

/// Of a whole run without gaps, by the definition of every part.
struct Reference {
    std::vector<double> amplitude;
    std::vector<double> density_per_rtHz;
};

Reference slow_spectrum(const std::vector<double> &values, std::size_t length, double rate_Hz) {
    const double mean =
        std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    const auto window = [length](std::size_t i) {
        return std::pow(std::sin(pi * static_cast<double>(i) / static_cast<double>(length)), 2);
    };
    double window_sum = 0.0;
    double window_power = 0.0;
    for (std::size_t i = 0; i < length; ++i) {
        window_sum += window(i);
        window_power += window(i) * window(i);
    }
    Reference result;
    for (std::size_t bin = 0; bin <= length / 2; ++bin) {
        double mean_power = 0.0;
        double segments = 0.0;
        for (std::size_t start = 0; start + length <= values.size(); start += length / 2) {
            std::complex<double> X = 0.0;
            for (std::size_t i = 0; i < length; ++i) {
                const auto steps = static_cast<double>(bin * i % length);
                X += window(i) * (values[start + i] - mean) *
                     std::polar(1.0, -2.0 * pi * steps / static_cast<double>(length));
            }
            mean_power += std::norm(X);
            segments += 1.0;
        }
        mean_power /= segments;
        const bool is_end = bin == 0 || bin == length / 2;
        result.amplitude.push_back((is_end ? 1.0 : 2.0) * std::sqrt(mean_power) / window_sum);
        result.density_per_rtHz.push_back(
            std::sqrt((is_end ? 1.0 : 2.0) * mean_power / (rate_Hz * window_power)));
    }
    return result;
}

TEST(Spectrum, ASineOnABinShowsItsAmplitudeThereAndHalfOfItBeside) {
    for (const double amplitude : {1e-6, 1.0, 250.0}) {
        for (const std::size_t bin : {4U, 40U, 100U}) {
            const Spectrum spectrum =
                amplitude_spectrum(sine(static_cast<double>(bin), amplitude), kRate_Hz);
            ASSERT_EQ(spectrum.amplitude.size(), kSegment / 2 + 1);
            for (std::size_t i = 0; i < spectrum.amplitude.size(); ++i) {
                const double expected = i == bin                       ? amplitude
                                        : i + 1 == bin || i == bin + 1 ? amplitude / 2.0
                                                                       : 0.0;
                EXPECT_NEAR(spectrum.amplitude[i], expected, 1e-12 * amplitude) << bin << ' ' << i;
            }
            EXPECT_NEAR(power(spectrum), amplitude * amplitude / 2.0,
                        1e-12 * amplitude * amplitude);
        }
    }
}

TEST(Spectrum, BetweenTwoBinsASineShowsWhatTheWindowPasses) {
    for (int step = -5; step <= 5; ++step) {
        const double offset = 0.1 * step;
        const Spectrum spectrum = amplitude_spectrum(sine(64.0 + offset), kRate_Hz);
        const double x = pi * offset;
        const double sinc = step == 0 ? 1.0 : std::sin(x) / x;
        // The sine's negative frequency is 128 bins away.
        EXPECT_NEAR(spectrum.amplitude[64], sinc / (1.0 - offset * offset), 1e-5) << offset;
        const double largest = std::ranges::max(spectrum.amplitude);
        EXPECT_LT(20.0 * std::log10(1.0 / largest), 1.4237) << offset;
    }
}

TEST(Spectrum, OfASineAtHalfTheSampleRateIsInTheLastBin) {
    const Spectrum spectrum =
        amplitude_spectrum(sine(static_cast<double>(kSegment) / 2.0, 3.0, pi / 2.0), kRate_Hz);
    EXPECT_NEAR(spectrum.amplitude.back(), 3.0, 1e-10);
    EXPECT_NEAR(power(spectrum), 9.0, 1e-9);
}

TEST(Spectrum, LeavesOutTheMean) {
    const std::vector<double> constant(kEightSegments, 42.0);
    EXPECT_LT(std::ranges::max(amplitude_spectrum(constant, kRate_Hz).amplitude), 1e-12);

    const Spectrum alone = amplitude_spectrum(sine(30.0), kRate_Hz);
    const Spectrum raised = amplitude_spectrum(sum(sine(30.0), constant), kRate_Hz);
    for (std::size_t i = 0; i < alone.amplitude.size(); ++i) {
        EXPECT_NEAR(raised.amplitude[i], alone.amplitude[i], 1e-12) << i;
    }
}

TEST(Spectrum, SeparatesTwoTones) {
    const Spectrum spectrum = amplitude_spectrum(sum(sine(20.0, 5.0), sine(60.5, 1e-3)), kRate_Hz);
    EXPECT_NEAR(spectrum.amplitude[20], 5.0, 1e-6);
    // Side lobes of the large one do not reach the small one; both bins beside it show it alike.
    EXPECT_NEAR(spectrum.amplitude[60], 0.8488e-3, 1e-6);
    EXPECT_NEAR(spectrum.amplitude[61], 0.8488e-3, 1e-6);
    EXPECT_LT(spectrum.amplitude[40], 1e-6);
}

TEST(Spectrum, ResolvesTonesThreeBinsApart) {
    const Spectrum spectrum = amplitude_spectrum(sum(sine(50.0), sine(53.0)), kRate_Hz);
    EXPECT_NEAR(spectrum.amplitude[50], 1.0, 1e-12);
    EXPECT_NEAR(spectrum.amplitude[53], 1.0, 1e-12);
    EXPECT_NEAR(spectrum.amplitude[51], 0.5, 1e-12);
}

TEST(Spectrum, BinsAreSpacedByTheRateOverTheLength) {
    const Spectrum spectrum = amplitude_spectrum(sine(10.0), 3000.0);
    EXPECT_DOUBLE_EQ(spectrum.bin_Hz, 3000.0 / kSegment);
    EXPECT_DOUBLE_EQ(spectrum.resolution_Hz, 1.5 * spectrum.bin_Hz);
    EXPECT_EQ(spectrum.segments, 8U);
}

TEST(Spectrum, TheDensityOfWhiteNoiseIsFlatAndSumsUpToItsVariance) {
    constexpr double kSigma = 0.7;
    constexpr std::size_t kSamples = 200'000; // 11 segments
    for (const double rate_Hz : {500.0, 10'000.0}) {
        const Spectrum spectrum = amplitude_spectrum(white_noise(kSamples, kSigma, 3), rate_Hz);
        // An estimate of the variance spreads by √(2/samples) = 0.3 %.
        EXPECT_NEAR(power(spectrum), kSigma * kSigma, 0.012 * kSigma * kSigma);
        // In a 16th of the band it spreads by four times that.
        const std::size_t part = spectrum.density_per_rtHz.size() / 16;
        for (std::size_t first = 0; first + part < spectrum.density_per_rtHz.size();
             first += part) {
            double mean_square = 0.0;
            for (std::size_t i = first; i < first + part; ++i) {
                mean_square +=
                    std::pow(spectrum.density_per_rtHz[i], 2) / static_cast<double>(part);
            }
            const double expected = kSigma * kSigma * 2.0 / rate_Hz;
            EXPECT_NEAR(mean_square, expected, 0.06 * expected) << first;
        }
    }
}

TEST(Spectrum, OfOneSegmentHasExactlyTheWindowedPower) {
    std::vector<double> values = white_noise(64, 1.0, 4);
    const double mean = std::accumulate(values.begin(), values.end(), 0.0) / 64.0;
    double expected = 0.0;
    for (std::size_t i = 0; i < 64; ++i) {
        const double window = 0.5 - 0.5 * std::cos(2.0 * pi * static_cast<double>(i) / 64.0);
        expected += std::pow(window * (values[i] - mean), 2) / (64.0 * 3.0 / 8.0);
    }
    EXPECT_NEAR(power(amplitude_spectrum(values, kRate_Hz)), expected, 1e-12);
}

TEST(Spectrum, NoiseReadsAsAmplitudeByTheResolution) {
    const Spectrum spectrum = amplitude_spectrum(white_noise(5000, 1.0, 5), kRate_Hz);
    for (std::size_t i = 1; i + 1 < spectrum.amplitude.size(); ++i) {
        const double expected =
            spectrum.density_per_rtHz[i] * std::sqrt(2.0 * spectrum.resolution_Hz);
        EXPECT_NEAR(spectrum.amplitude[i], expected, 1e-14);
    }
}

TEST(Spectrum, IsThatOfItsDefinition) {
    struct Case {
        std::size_t samples;
        std::size_t length;
        std::size_t segments;
    };
    for (const auto &[samples, length, segments] :
         {Case{64, 64, 1}, Case{95, 64, 1}, Case{96, 64, 2}, Case{287, 64, 7}, Case{288, 64, 8},
          Case{575, 64, 16}, Case{576, 128, 8}, Case{1000, 128, 14}, Case{1152, 256, 8}}) {
        const std::vector<double> values =
            sum(white_noise(samples, 1.0, samples), std::vector<double>(samples, 10.0));
        const Spectrum spectrum = amplitude_spectrum(values, 2500.0);
        const Reference reference = slow_spectrum(values, length, 2500.0);
        EXPECT_EQ(spectrum.segments, segments) << samples;
        EXPECT_DOUBLE_EQ(spectrum.bin_Hz, 2500.0 / static_cast<double>(length)) << samples;
        ASSERT_EQ(spectrum.amplitude.size(), reference.amplitude.size()) << samples;
        ASSERT_EQ(spectrum.density_per_rtHz.size(), reference.amplitude.size()) << samples;
        for (std::size_t i = 0; i < reference.amplitude.size(); ++i) {
            EXPECT_NEAR(spectrum.amplitude[i], reference.amplitude[i], 1e-12) << samples;
            EXPECT_NEAR(spectrum.density_per_rtHz[i], reference.density_per_rtHz[i], 1e-13)
                << samples;
        }
    }
}

TEST(Spectrum, NeedsSixtyFourSamples) {
    for (const std::size_t samples : {0U, 1U, 63U}) {
        const Spectrum spectrum = amplitude_spectrum(white_noise(samples, 1.0, 6), kRate_Hz);
        EXPECT_TRUE(spectrum.amplitude.empty());
        EXPECT_TRUE(spectrum.density_per_rtHz.empty());
        EXPECT_EQ(spectrum.segments, 0U);
    }
    EXPECT_EQ(amplitude_spectrum(white_noise(64, 1.0, 6), kRate_Hz).segments, 1U);
}

TEST(Spectrum, IsThatOfTheLongestRunBetweenGaps) {
    const std::vector<double> run = white_noise(500, 1.0, 7);
    const std::vector<double> other = white_noise(499, 9.0, 8);
    const Spectrum expected = amplitude_spectrum(run, kRate_Hz);
    for (const double gap : {std::nan(""), std::numeric_limits<double>::infinity()}) {
        for (const std::ptrdiff_t before : {0, 100, 499}) {
            for (const std::ptrdiff_t after : {0, 100, 499}) {
                std::vector<double> values(other.begin(), other.begin() + before);
                values.insert(values.end(), {gap, gap});
                values.insert(values.end(), run.begin(), run.end());
                values.push_back(gap);
                values.insert(values.end(), other.begin(), other.begin() + after);
                const Spectrum spectrum = amplitude_spectrum(values, kRate_Hz);
                EXPECT_TRUE(spectrum.amplitude == expected.amplitude) << before << ' ' << after;
            }
        }
    }
}

TEST(Spectrum, IsThatOfTheFirstOfEqualRuns) {
    const std::vector<double> first = white_noise(500, 1.0, 7);
    std::vector<double> values = first;
    values.push_back(std::nan(""));
    values.insert(values.end(), 500, 1.0);
    EXPECT_TRUE(amplitude_spectrum(values, kRate_Hz).amplitude ==
                amplitude_spectrum(first, kRate_Hz).amplitude);
}

TEST(Spectrum, IsEmptyIfNoRunIsLongEnough) {
    std::vector<double> torn = white_noise(1000, 1.0, 10);
    for (std::size_t i = 0; i < torn.size(); i += 64) {
        torn[i] = std::nan(""); // 63 samples between them
    }
    EXPECT_EQ(amplitude_spectrum(torn, kRate_Hz).segments, 0U);
}

TEST(SpectrumDeathTest, NeedsARate) {
    EXPECT_DEATH(static_cast<void>(amplitude_spectrum({}, 0.0)), "sample_rate_hz > 0.0");
    EXPECT_DEATH(static_cast<void>(amplitude_spectrum({}, std::nan(""))), "sample_rate_hz > 0.0");
}

} // namespace
} // namespace springdrive::signals
