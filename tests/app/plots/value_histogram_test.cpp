// Covers app/plots/value_histogram.cpp.
#include "app/plots/value_histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

namespace springdrive::signals {
namespace {

using Counts = std::vector<std::uint64_t>;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

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
    EXPECT_EQ(histogram.not_a_number, number_of(values, [](double v) { return std::isnan(v); }));
    EXPECT_EQ(in_bins(histogram) + histogram.below + histogram.above + histogram.not_a_number,
              values.size());
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
        value = which == 0   ? kNotANumber
                : which == 1 ? std::copysign(kInfinite, normal(random))
                : which < 8  ? std::pow(10.0, std::round(std::log10(scale))) * (which - 5)
                             : offset + scale * normal(random);
    }
    return values;
}

TEST(Histogram, CountsWhatIsBetweenItsEdges) {
    const std::vector<double> values{-0.1, 0.0, 0.9, 1.0, 2.5, 4.0, 4.1, kNotANumber, -7.0};
    const ValueHistogram result = histogram(values, 0.0, 4.0, 4);
    EXPECT_EQ(result.counts, (Counts{2, 1, 1, 1})); // 4.0 is in the last bin
    EXPECT_EQ(result.below, 2U);
    EXPECT_EQ(result.above, 1U);
    EXPECT_EQ(result.not_a_number, 1U);
    EXPECT_EQ(result.from, 0.0);
    EXPECT_EQ(result.to, 4.0);
    EXPECT_EQ(result.edge(3), 3.0);
}

TEST(Histogram, AnInfiniteValueIsBelowOrAbove) {
    const std::vector<double> values{kInfinite, -kInfinite, kInfinite};
    const ValueHistogram result = histogram(values, -1.0, 1.0, 2);
    EXPECT_EQ(in_bins(result), 0U);
    EXPECT_EQ(result.below, 1U);
    EXPECT_EQ(result.above, 2U);
}

TEST(Histogram, OfNothingIsEmpty) {
    const ValueHistogram result = histogram({}, 0.0, 1.0, 3);
    EXPECT_EQ(result.counts, (Counts{0, 0, 0}));
    EXPECT_EQ(result.below + result.above + result.not_a_number, 0U);
}

TEST(Histogram, AWholeNumberIsInTheBinThatBeginsWithIt) {
    for (std::size_t bins = 1; bins <= 200; ++bins) {
        std::vector<double> values(bins);
        std::iota(values.begin(), values.end(), -20.0);
        const double to = -20.0 + static_cast<double>(bins);
        EXPECT_EQ(histogram(values, -20.0, to, bins).counts, Counts(bins, 1)) << bins;
    }
}

TEST(Histogram, CountsAsDefinedInRandomCases) {
    std::mt19937_64 random(1);
    std::uniform_int_distribution<std::size_t> any_bins(1, 60);
    for (int trial = 0; trial < 500; ++trial) {
        const std::vector<double> values = random_values(random);
        const double from = quantile(values, 0.2);
        const double to = quantile(values, 0.9);
        if (from < to && std::isfinite(to - from)) {
            expect_counted_as_defined(histogram(values, from, to, any_bins(random)), values);
        }
    }
}

TEST(Histogram, CountsAsDefinedInARangeOfFewNumbers) {
    const double next = std::nextafter(std::nextafter(1.0, 2.0), 2.0); // one number between
    const std::vector<double> values{1.0, std::nextafter(1.0, 2.0), next, 2.0, 0.0};
    for (const std::size_t bins : {1U, 2U, 3U, 10U}) {
        expect_counted_as_defined(histogram(values, 1.0, next, bins), values);
    }
}

TEST(HistogramDeathTest, NeedsARangeAndABin) {
    EXPECT_DEATH(static_cast<void>(histogram({}, 1.0, 1.0, 1)), "from < to");
    EXPECT_DEATH(static_cast<void>(histogram({}, 0.0, kInfinite, 1)), "isfinite");
    EXPECT_DEATH(static_cast<void>(histogram({}, kNotANumber, 1.0, 1)), "from < to");
    EXPECT_DEATH(static_cast<void>(histogram({}, 0.0, 1.0, 0)), "bins > 0");
}

/// 1, 2 or 5 times a power of ten.
bool is_round(double width) {
    const double digit = width / std::pow(10.0, std::floor(std::log10(width * (1.0 + 1e-9))));
    return std::min({std::abs(digit - 1.0), std::abs(digit - 2.0), std::abs(digit - 5.0)}) < 1e-9;
}

TEST(AutomaticHistogram, ChoosesTheNarrowestRoundBins) {
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
          Case{0.3, 0.9, 7, 0.3, 0.9, 6}, Case{-2e-6, -1.1e-6, 50, -2e-6, -1.1e-6, 45}}) {
        const std::vector<double> values{each.largest, each.smallest};
        const ValueHistogram result = automatic_histogram(values, Coverage::all, each.max_bins);
        EXPECT_EQ(result.from, each.from); // the same doubles as the decimal numbers
        EXPECT_EQ(result.to, each.to);
        EXPECT_EQ(result.counts.size(), each.bins);
        EXPECT_EQ(in_bins(result), 2U);
    }
}

TEST(AutomaticHistogram, EndsAtZeroWithoutASign) {
    EXPECT_FALSE(
        std::signbit(automatic_histogram(std::vector<double>{-0.0, 9.0}, Coverage::all, 10).from));
    EXPECT_FALSE(
        std::signbit(automatic_histogram(std::vector<double>{-9.0, -0.1}, Coverage::all, 10).to));
}

TEST(AutomaticHistogram, CoversAllOrMostOfRandomValuesWithRoundBins) {
    std::mt19937_64 random(2);
    std::uniform_int_distribution<std::size_t> any_bins(2, 120);
    for (int trial = 0; trial < 1000; ++trial) {
        std::vector<double> values = random_values(random);
        const std::size_t max_bins = any_bins(random);
        const ValueHistogram all = automatic_histogram(values, Coverage::all, max_bins);
        const ValueHistogram most = automatic_histogram(values, Coverage::most, max_bins);
        for (const ValueHistogram &each : {all, most}) {
            expect_counted_as_defined(each, values);
            EXPECT_LE(each.counts.size(), max_bins);
            EXPECT_TRUE(is_round(each.bin_width())) << each.bin_width();
            const double multiple = each.from / each.bin_width();
            EXPECT_NEAR(multiple, std::round(multiple), 1e-9);
        }
        std::erase_if(values, [](double value) { return !std::isfinite(value); });
        EXPECT_EQ(in_bins(all), values.size());
        EXPECT_LE(most.bin_width(), all.bin_width());
        if (!values.empty()) {
            EXPECT_LE(most.from, quantile(values, 0.001));
            EXPECT_GE(most.to, quantile(values, 0.999));
        }
    }
}

TEST(AutomaticHistogram, OutliersDoNotHideTheRest) {
    std::vector<double> values(9990);
    std::iota(values.begin(), values.end(), 0.0);
    values.insert(values.end(), {1e9, 1e9, -1e9, kInfinite, kNotANumber});
    const ValueHistogram result = automatic_histogram(values, Coverage::most, 100);
    EXPECT_EQ(result.from, 0.0);
    EXPECT_EQ(result.to, 10'000.0);
    EXPECT_EQ(result.counts.size(), 100U);
    EXPECT_EQ(in_bins(result), 9990U);
    EXPECT_EQ(result.below, 1U);
    EXPECT_EQ(result.above, 3U);
    EXPECT_EQ(result.not_a_number, 1U);
}

TEST(AutomaticHistogram, LeavesOutAThousandthAtEachEnd) {
    std::vector<double> values(100'000);
    std::iota(values.begin(), values.end(), 1.0);
    const ValueHistogram result = automatic_histogram(values, Coverage::most, 10'000);
    EXPECT_EQ(result.bin_width(), 10.0);
    EXPECT_EQ(result.from, 100.0);
    EXPECT_EQ(result.to, 99'900.0);
}

TEST(AutomaticHistogram, EqualValuesAreInTheMiddleOfARange) {
    for (const double value : {0.0, 5e-324, 1e-200, 3.0, -24.0, 1e15, -1e300}) {
        // Round-off of equal values makes no difference either.
        const std::vector<double> values{value, std::nextafter(value, kInfinite), value};
        const ValueHistogram result = automatic_histogram(values, Coverage::all, 20);
        expect_counted_as_defined(result, values);
        EXPECT_EQ(in_bins(result), 3U) << value;
        EXPECT_LT(result.from, value);
        EXPECT_GT(result.to, value);
        EXPECT_NEAR((result.from + result.to) / 2.0, value, 0.05 * (result.to - result.from))
            << value;
    }
}

TEST(AutomaticHistogram, WithoutFiniteValuesHasARangeNevertheless) {
    for (const std::vector<double> &values :
         {std::vector<double>{}, std::vector<double>{kNotANumber},
          std::vector<double>{-kInfinite}}) {
        const ValueHistogram result = automatic_histogram(values, Coverage::most, 10);
        EXPECT_EQ(result.from, -1.0);
        EXPECT_EQ(result.to, 1.0);
        EXPECT_EQ(result.counts, Counts(10, 0));
        expect_counted_as_defined(result, values);
    }
}

TEST(AutomaticHistogram, CopesWithNumbersOfAnySize) {
    const double largest = std::numeric_limits<double>::max();
    for (const double size : {5e-324, 1e-310, 1e-250, 1e250, 1e300, largest}) {
        const std::vector<double> values{-size, 0.0, size, size / 3.0};
        for (const std::size_t max_bins : {2U, 10'000U}) {
            const ValueHistogram result = automatic_histogram(values, Coverage::all, max_bins);
            EXPECT_TRUE(std::isfinite(result.to - result.from)) << size;
            EXPECT_EQ(in_bins(result), size < largest ? 4U : 1U) << size;
            EXPECT_LE(result.counts.size(), max_bins);
        }
    }
}

TEST(AutomaticHistogramDeathTest, NeedsTwoBins) {
    EXPECT_DEATH(static_cast<void>(automatic_histogram({}, Coverage::all, 1)), "max_bins >= 2");
    EXPECT_DEATH(static_cast<void>(automatic_histogram({}, Coverage::all, 10'001)), "kMaxBins");
}

TEST(Quantile, IsTheSmallestValueThatTheShareDoesNotExceed) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> any_fraction(0.0, 1.0);
    for (int trial = 0; trial < 500; ++trial) {
        const std::vector<double> values = random_values(random);
        const std::uint64_t numbers =
            number_of(values, [](double value) { return !std::isnan(value); });
        if (numbers == 0) {
            continue;
        }
        for (const double fraction : {0.0, 0.001, 0.25, any_fraction(random), 1.0}) {
            const double result = quantile(values, fraction);
            const double wanted = fraction * static_cast<double>(numbers);
            const auto at_most = number_of(values, [=](double v) { return v <= result; });
            const auto less = number_of(values, [=](double v) { return v < result; });
            EXPECT_EQ(number_of(values, [=](double v) { return v == result; }), at_most - less);
            EXPECT_GT(at_most, less); // it is one of the values
            EXPECT_GE(static_cast<double>(at_most), wanted);
            EXPECT_LT(static_cast<double>(less), std::max(wanted, 0.5));
        }
    }
}

TEST(Quantile, OfKnownValues) {
    const std::vector<double> values{5.0, kNotANumber, 1.0, 3.0, 2.0, kNotANumber, 4.0};
    EXPECT_EQ(quantile(values, 0.0), 1.0);
    EXPECT_EQ(quantile(values, 0.2), 1.0);
    EXPECT_EQ(quantile(values, 0.21), 2.0);
    EXPECT_EQ(quantile(values, 0.5), 3.0);
    EXPECT_EQ(quantile(values, 1.0), 5.0);
    EXPECT_EQ(quantile(std::vector<double>{kInfinite, -kInfinite}, 0.9), kInfinite);
}

TEST(Quantile, OfNothingIsNotANumber) {
    EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
    EXPECT_TRUE(std::isnan(quantile(std::vector<double>{kNotANumber}, 0.5)));
}

TEST(QuantileDeathTest, NeedsAFraction) {
    EXPECT_DEATH(static_cast<void>(quantile({}, -0.1)), "fraction >= 0.0");
    EXPECT_DEATH(static_cast<void>(quantile({}, 1.1)), "fraction <= 1.0");
    EXPECT_DEATH(static_cast<void>(quantile({}, kNotANumber)), "fraction >= 0.0");
}

} // namespace
} // namespace springdrive::signals
