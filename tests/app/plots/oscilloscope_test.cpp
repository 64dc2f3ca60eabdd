// Covers app/plots/oscilloscope.cpp.
#include "app/plots/oscilloscope.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

namespace springdrive::signals {
namespace {

using std::numbers::pi;

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
constexpr double kEndless = std::numeric_limits<double>::infinity();

// --- spectrum ---

constexpr double kRate_Hz = 1000.0;
constexpr std::size_t kSegment = 256;
constexpr std::size_t kEightSegments = kSegment * 9 / 2;

/// A sine of `bins` whole or broken bins of `kSegment`.
std::vector<double> sine(double bins, double amplitude = 1.0) {
    std::vector<double> values;
    for (std::size_t i = 0; i < kEightSegments; ++i) {
        const double turns = bins * static_cast<double>(i) / static_cast<double>(kSegment);
        values.push_back(amplitude * std::sin(2.0 * pi * turns + 0.3));
    }
    return values;
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
Spectrum slow_spectrum(const std::vector<double> &values, std::size_t length, double rate_Hz) {
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
    Spectrum result;
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

TEST(Spectrum, IsThatOfItsDefinition) {
    struct Case {
        std::size_t samples;
        std::size_t length;
        std::size_t segments;
    };
    for (const auto &[samples, length, segments] :
         {Case{64, 64, 1}, Case{95, 64, 1}, Case{96, 64, 2}, Case{287, 64, 7}, Case{288, 64, 8},
          Case{575, 64, 16}, Case{576, 128, 8}, Case{1000, 128, 14}, Case{1152, 256, 8}}) {
        std::vector<double> values = white_noise(samples, 1.0, samples);
        for (double &value : values) {
            value += 10.0; // the mean
        }
        const Spectrum spectrum = amplitude_spectrum(values, 2500.0);
        const Spectrum reference = slow_spectrum(values, length, 2500.0);
        EXPECT_EQ(spectrum.segments, segments) << samples;
        EXPECT_DOUBLE_EQ(spectrum.bin_Hz, 2500.0 / static_cast<double>(length)) << samples;
        EXPECT_DOUBLE_EQ(spectrum.resolution_Hz, 1.5 * spectrum.bin_Hz);
        ASSERT_EQ(spectrum.amplitude.size(), reference.amplitude.size()) << samples;
        ASSERT_EQ(spectrum.density_per_rtHz.size(), reference.amplitude.size()) << samples;
        for (std::size_t i = 0; i < reference.amplitude.size(); ++i) {
            EXPECT_NEAR(spectrum.amplitude[i], reference.amplitude[i], 1e-12) << samples;
            EXPECT_NEAR(spectrum.density_per_rtHz[i], reference.density_per_rtHz[i], 1e-13)
                << samples;
        }
    }
}

TEST(Spectrum, ASineOnABinShowsItsAmplitudeThereAndHalfOfItBeside) {
    for (const double amplitude : {1e-6, 250.0}) {
        for (const std::size_t bin : {4U, 100U}) {
            const Spectrum spectrum =
                amplitude_spectrum(sine(static_cast<double>(bin), amplitude), kRate_Hz);
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

TEST(Spectrum, TheDensityOfWhiteNoiseIsFlatAndSumsUpToItsVariance) {
    constexpr double kSigma = 0.7;
    constexpr std::size_t kSamples = 200'000; // 11 segments
    constexpr double kNoiseRate_Hz = 10'000.0;
    const Spectrum spectrum = amplitude_spectrum(white_noise(kSamples, kSigma, 3), kNoiseRate_Hz);
    // An estimate of the variance spreads by √(2/samples) = 0.3 %; in a 16th of the band it spreads
    // by four times that.
    EXPECT_NEAR(power(spectrum), kSigma * kSigma, 0.012 * kSigma * kSigma);
    const std::size_t part = spectrum.density_per_rtHz.size() / 16;
    for (std::size_t first = 0; first + part < spectrum.density_per_rtHz.size(); first += part) {
        double mean_square = 0.0;
        for (std::size_t i = first; i < first + part; ++i) {
            mean_square += std::pow(spectrum.density_per_rtHz[i], 2) / static_cast<double>(part);
        }
        const double expected = kSigma * kSigma * 2.0 / kNoiseRate_Hz;
        EXPECT_NEAR(mean_square, expected, 0.06 * expected) << first;
    }
    for (std::size_t i = 1; i + 1 < spectrum.amplitude.size(); ++i) { // read as an amplitude
        EXPECT_NEAR(spectrum.amplitude[i],
                    spectrum.density_per_rtHz[i] * std::sqrt(2.0 * spectrum.resolution_Hz), 1e-14);
    }
}

TEST(Spectrum, IsThatOfTheLongestRunBetweenGapsTheFirstOfEqualOnes) {
    const std::vector<double> run = white_noise(500, 1.0, 7);
    const std::vector<double> other = white_noise(500, 9.0, 8);
    const Spectrum expected = amplitude_spectrum(run, kRate_Hz);
    for (const double gap : {kMissing, kEndless}) {
        for (const std::ptrdiff_t before : {0, 100, 499}) {
            for (const std::ptrdiff_t after : {0, 100, 500}) {
                std::vector<double> values(other.begin(), other.begin() + before);
                values.insert(values.end(), {gap, gap});
                values.insert(values.end(), run.begin(), run.end());
                values.push_back(gap);
                values.insert(values.end(), other.begin(), other.begin() + after);
                EXPECT_TRUE(amplitude_spectrum(values, kRate_Hz).amplitude == expected.amplitude)
                    << before << ' ' << after;
            }
        }
    }
}

TEST(Spectrum, NeedsSixtyFourSamplesInARowAndARate) {
    std::vector<double> torn = white_noise(1000, 1.0, 10);
    for (std::size_t i = 0; i < torn.size(); i += 64) {
        torn[i] = kMissing; // 63 samples between them
    }
    for (const std::vector<double> &values :
         {std::vector<double>(), white_noise(63, 1.0, 6), torn}) {
        const Spectrum spectrum = amplitude_spectrum(values, kRate_Hz);
        EXPECT_TRUE(spectrum.amplitude.empty());
        EXPECT_TRUE(spectrum.density_per_rtHz.empty());
        EXPECT_EQ(spectrum.segments, 0U);
    }
    EXPECT_DEATH(static_cast<void>(amplitude_spectrum({}, 0.0)), "sample_rate_hz > 0.0");
    EXPECT_DEATH(static_cast<void>(amplitude_spectrum({}, kMissing)), "sample_rate_hz > 0.0");
}

// --- histogram ---

std::uint64_t in_bins(const ValueHistogram &histogram) {
    return std::accumulate(histogram.counts.begin(), histogram.counts.end(), std::uint64_t{0});
}

std::uint64_t number_of(const std::vector<double> &values, auto condition) {
    return static_cast<std::uint64_t>(std::ranges::count_if(values, condition));
}

/// Counts all values anew for every bin.
void expect_counted_as_defined(const ValueHistogram &histogram, const std::vector<double> &values) {
    for (std::size_t bin = 0; bin < histogram.counts.size(); ++bin) {
        const bool is_last = bin + 1 == histogram.counts.size();
        const auto is_in = [&](double value) {
            return value >= histogram.edge(bin) &&
                   (is_last ? value <= histogram.to : value < histogram.edge(bin + 1));
        };
        EXPECT_EQ(histogram.counts[bin], number_of(values, is_in)) << bin;
    }
    EXPECT_EQ(histogram.below, number_of(values, [&](double v) { return v < histogram.from; }));
    EXPECT_EQ(histogram.above, number_of(values, [&](double v) { return v > histogram.to; }));
    EXPECT_EQ(in_bins(histogram) + histogram.below + histogram.above,
              number_of(values, [](double v) { return !std::isnan(v); }));
}

/// Of any size, with some on edges and some that are no numbers.
std::vector<double> random_values(std::mt19937_64 &random) {
    std::uniform_int_distribution<int> kind(0, 20);
    std::uniform_int_distribution<int> count(0, 400);
    std::uniform_real_distribution<double> exponent(-6.0, 6.0);
    std::normal_distribution<double> normal;
    const double scale = std::pow(10.0, exponent(random));
    const double offset = kind(random) < 10 ? 0.0 : 10.0 * scale * normal(random);
    std::vector<double> values(static_cast<std::size_t>(count(random)));
    for (double &value : values) {
        const int which = kind(random);
        value = which == 0   ? kMissing
                : which == 1 ? std::copysign(kEndless, normal(random))
                : which < 8  ? std::pow(10.0, std::round(std::log10(scale))) * (which - 5)
                             : offset + scale * normal(random);
    }
    return values;
}

/// 1, 2 or 5 times a power of ten.
bool is_round_width(double width) {
    const double digit = width / std::pow(10.0, std::floor(std::log10(width * (1.0 + 1e-9))));
    return std::min({std::abs(digit - 1.0), std::abs(digit - 2.0), std::abs(digit - 5.0)}) < 1e-9;
}

/// The smallest of the finite values that a share of them does not exceed, by counting.
double slow_quantile(std::vector<double> values, double share) {
    std::erase_if(values, [](double value) { return !std::isfinite(value); });
    std::ranges::sort(values);
    const double rank = std::max(1.0, std::ceil(share * static_cast<double>(values.size())));
    return values.at(static_cast<std::size_t>(rank) - 1);
}

TEST(Histogram, ChoosesTheNarrowestRoundBins) {
    struct Case {
        double smallest;
        double largest;
        std::size_t max_bins;
        double from;
        double to;
        std::size_t bins;
    };
    for (const Case &each :
         {Case{0.0, 10.0, 10, 0.0, 10.0, 10}, Case{0.1, 9.7, 10, 0.0, 10.0, 10},
          Case{-0.1, 9.7, 10, -2.0, 10.0, 6}, Case{-3.1, 2.4, 20, -3.5, 2.5, 12},
          Case{1001.0, 1003.0, 100, 1001.0, 1003.0, 100}, Case{-1.0, 1.0, 2, -1.0, 1.0, 2},
          Case{0.3, 0.9, 7, 0.3, 0.9, 6}, Case{-2e-6, -1.1e-6, 50, -2e-6, -1.1e-6, 45},
          Case{-0.0, 9.0, 10, 0.0, 9.0, 9}, Case{-9.0, -0.1, 10, -9.0, 0.0, 9}}) {
        const std::vector<double> values{each.largest, each.smallest};
        const ValueHistogram result = histogram(values, each.max_bins);
        EXPECT_EQ(result.from, each.from); // the same doubles as the decimal numbers
        EXPECT_EQ(result.to, each.to);
        EXPECT_FALSE(std::signbit(result.to) && result.to == 0.0);
        EXPECT_FALSE(std::signbit(result.from) && result.from == 0.0);
        EXPECT_EQ(result.counts.size(), each.bins);
        EXPECT_EQ(in_bins(result), 2U);
    }
}

TEST(Histogram, CoversMostOfRandomValuesWithRoundBinsAndCountsAsDefined) {
    std::mt19937_64 random(2);
    std::uniform_int_distribution<std::size_t> any_bins(2, 120);
    for (int trial = 0; trial < 1000; ++trial) {
        const std::vector<double> values = random_values(random);
        const std::size_t max_bins = any_bins(random);
        const ValueHistogram result = histogram(values, max_bins);
        expect_counted_as_defined(result, values);
        EXPECT_LE(result.counts.size(), max_bins);
        EXPECT_TRUE(is_round_width(result.bin_width())) << result.bin_width();
        const double multiple = result.from / result.bin_width();
        EXPECT_NEAR(multiple, std::round(multiple), 1e-9);
        if (std::ranges::any_of(values, [](double value) { return std::isfinite(value); })) {
            EXPECT_LE(result.from, slow_quantile(values, 0.001));
            EXPECT_GE(result.to, slow_quantile(values, 0.999));
        }
    }
}

TEST(Histogram, LeavesOutAThousandthAtEachEndAndOutliers) {
    std::vector<double> values(100'000);
    std::iota(values.begin(), values.end(), 1.0);
    const ValueHistogram all = histogram(values, 10'000);
    EXPECT_EQ(all.bin_width(), 10.0);
    EXPECT_EQ(all.from, 100.0);
    EXPECT_EQ(all.to, 99'900.0);
    values.resize(9990);
    std::iota(values.begin(), values.end(), 0.0);
    values.insert(values.end(), {1e9, 1e9, -1e9, kEndless, kMissing});
    const ValueHistogram most = histogram(values, 100);
    EXPECT_EQ(most.from, 0.0);
    EXPECT_EQ(most.to, 10'000.0);
    EXPECT_EQ(most.counts.size(), 100U);
    EXPECT_EQ(in_bins(most), 9990U);
    EXPECT_EQ(most.below, 1U);
    EXPECT_EQ(most.above, 3U);
}

TEST(Histogram, OfEqualValuesOrNoneHasARangeNevertheless) {
    for (const double value : {0.0, 5e-324, 1e-200, 3.0, -24.0, 1e15, -1e300}) {
        // Round-off of equal values makes no difference either.
        const std::vector<double> values{value, std::nextafter(value, kEndless), value};
        const ValueHistogram result = histogram(values, 20);
        expect_counted_as_defined(result, values);
        EXPECT_EQ(in_bins(result), 3U) << value;
        EXPECT_LT(result.from, value);
        EXPECT_GT(result.to, value);
        EXPECT_NEAR((result.from + result.to) / 2.0, value, 0.05 * (result.to - result.from))
            << value;
    }
    for (const std::vector<double> &values :
         {std::vector<double>{}, std::vector<double>{kMissing}, std::vector<double>{-kEndless}}) {
        const ValueHistogram result = histogram(values, 10);
        EXPECT_EQ(result.from, -1.0);
        EXPECT_EQ(result.to, 1.0);
        expect_counted_as_defined(result, values);
    }
}

TEST(Histogram, CopesWithNumbersOfAnySizeAndNeedsTwoBins) {
    const double largest = std::numeric_limits<double>::max();
    for (const double size : {5e-324, 1e-310, 1e-250, 1e250, 1e300, largest}) {
        const std::vector<double> values{-size, 0.0, size, size / 3.0};
        for (const std::size_t max_bins : {2U, 10'000U}) {
            const ValueHistogram result = histogram(values, max_bins);
            EXPECT_TRUE(std::isfinite(result.to - result.from)) << size;
            EXPECT_EQ(in_bins(result), size < largest ? 4U : 1U) << size;
            EXPECT_LE(result.counts.size(), max_bins);
        }
    }
    EXPECT_DEATH(static_cast<void>(histogram({}, 1)), "max_bins >= 2");
    EXPECT_DEATH(static_cast<void>(histogram({}, 10'001)), "kMaxBins");
}

// --- trigger ---

using Indices = std::vector<int>;

/// The indices of the values that are events.
Indices events(const TriggerCondition &condition, const std::vector<double> &values) {
    EdgeDetector detector(condition);
    Indices all;
    for (int i = 0; i < static_cast<int>(values.size()); ++i) {
        if (detector.take(values[static_cast<std::size_t>(i)])) {
            all.push_back(i);
        }
    }
    return all;
}

TEST(EdgeDetector, FiresWhereTheLevelIsPassedWhichItselfIsLow) {
    const std::vector<double> wave{0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0, 3.0, 0.0};
    EXPECT_EQ(events({TriggerEdge::rising, 1.5}, wave), (Indices{2, 7}));
    EXPECT_EQ(events({TriggerEdge::falling, 1.5}, wave), (Indices{5, 8}));
    EXPECT_EQ(events({TriggerEdge::either, 1.5}, wave), (Indices{2, 5, 7, 8}));
    const std::vector<double> contact{0.0, 0.0, 1e-9, 5.0, 0.0, 0.0};
    EXPECT_EQ(events({TriggerEdge::rising, 0.0}, contact), Indices{2});
    EXPECT_EQ(events({TriggerEdge::falling, 0.0}, contact), Indices{4});
    EXPECT_EQ(events({TriggerEdge::rising, 5.0}, contact), Indices{});
    EXPECT_EQ(events({TriggerEdge::change, 99.0}, {1.0, 1.0, 2.0, 1.0, kEndless, 0.0, -0.0}),
              (Indices{2, 3, 4, 5}));
}

/// Without any state: the last number before a value decides.
bool is_event(const std::vector<double> &values, std::size_t i, const TriggerCondition &condition) {
    const auto is_high = [&](double value) { return value > condition.level; };
    for (std::size_t j = i; j-- > 0 && !std::isnan(values[i]);) {
        if (!std::isnan(values[j])) {
            const bool rises = is_high(values[i]) && !is_high(values[j]);
            const bool falls = !is_high(values[i]) && is_high(values[j]);
            return condition.edge == TriggerEdge::rising    ? rises
                   : condition.edge == TriggerEdge::falling ? falls
                   : condition.edge == TriggerEdge::either  ? rises || falls
                                                            : values[j] != values[i];
        }
    }
    return false; // nor is the first one
}

TEST(EdgeDetector, FiresAsDefinedOnRandomSignals) {
    std::mt19937_64 random(2);
    std::uniform_int_distribution<int> any(-6, 8); // often equal to a level
    for (int trial = 0; trial < 2000; ++trial) {
        std::vector<double> values;
        for (int i = 0; i < 60; ++i) {
            const int number = any(random);
            values.push_back(number == 7   ? kMissing
                             : number == 8 ? std::copysign(kEndless, any(random))
                                           : number);
        }
        for (const TriggerEdge edge : {TriggerEdge::rising, TriggerEdge::falling,
                                       TriggerEdge::either, TriggerEdge::change}) {
            const TriggerCondition condition{edge, static_cast<double>(trial % 5 - 2)};
            EdgeDetector detector(condition);
            for (std::size_t i = 0; i < values.size(); ++i) {
                ASSERT_EQ(detector.take(values[i]), is_event(values, i, condition))
                    << trial << ' ' << i;
            }
        }
    }
}

TEST(Trigger, OnlyARepeatingOneProceedsAndEitherIsArmedAgainFromEveryState) {
    for (const TriggerMode mode : {TriggerMode::single, TriggerMode::repeating}) {
        Trigger trigger({mode, 0.0, 1.0});
        trigger.take(0.0, true);
        trigger.proceed(); // too early
        EXPECT_EQ(trigger.state(), TriggerState::collecting);
        EXPECT_FALSE(trigger.window());
        trigger.take(1.0, false);
        trigger.proceed();
        EXPECT_EQ(trigger.state(),
                  mode == TriggerMode::single ? TriggerState::complete : TriggerState::waiting);
        EXPECT_EQ(trigger.window().has_value(), mode == TriggerMode::single);
        trigger.take(2.0, true);
        trigger.take(3.0, false);
        EXPECT_EQ(trigger.window()->to_s, mode == TriggerMode::single ? 1.0 : 3.0);
    }
    for (const int ticks : {0, 1, 2, 3}) {
        Trigger trigger({TriggerMode::single, 1.0, 1.5});
        for (int i = 0; i < ticks; ++i) {
            trigger.take(10.0 + i, true);
        }
        trigger.arm();
        EXPECT_EQ(trigger.state(), TriggerState::waiting);
        EXPECT_FALSE(trigger.window());
        trigger.take(0.0, true); // earlier than before
        trigger.take(1.5, false);
        ASSERT_TRUE(trigger.window()) << ticks;
        EXPECT_EQ(trigger.window()->from_s, -1.0); // less is shown
        EXPECT_EQ(trigger.window()->to_s, 1.5);
    }
}

/// Every event that may be acquired is, and no other: the first one since the previous window's
/// last tick.
TEST(Trigger, AcquiresTheFirstPossibleEventOfRandomOnes) {
    std::mt19937_64 random(3);
    std::uniform_int_distribution<int> ticks(0, 12);
    for (int trial = 0; trial < 500; ++trial) {
        const int post = ticks(random);
        std::vector<bool> fired(300);
        std::generate(fired.begin(), fired.end(), [&] { return ticks(random) == 0; });
        std::vector<double> expected_s;
        for (int i = 0; i + post < 300; ++i) {
            if (fired[static_cast<std::size_t>(i)]) {
                expected_s.push_back(i);
                i += post;
            }
        }
        Trigger trigger({TriggerMode::repeating, 7.0, static_cast<double>(post)});
        std::vector<double> found_s;
        for (int i = 0; i < 300; ++i) {
            trigger.take(i, fired[static_cast<std::size_t>(i)]);
            if (const auto window = trigger.window()) {
                EXPECT_EQ(window->to_s, i);
                EXPECT_EQ(window->to_s - window->from_s, 7.0 + post);
                found_s.push_back(window->from_s + 7.0);
                trigger.proceed();
            }
        }
        EXPECT_EQ(found_s, expected_s) << trial;
    }
}

TEST(TriggerDeathTest, NeedsTimesThatAreNotNegative) {
    EXPECT_DEATH(Trigger({TriggerMode::single, -1.0, 0.0}), "pre_s >= 0.0");
    EXPECT_DEATH(Trigger({TriggerMode::single, 0.0, kMissing}), "post_s >= 0.0");
}

} // namespace
} // namespace springdrive::signals
