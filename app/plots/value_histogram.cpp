#include "app/plots/value_histogram.h"

#include "base/assertions.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace springdrive::signals {

namespace {

// Of numbers between these, or 0, the choice of bins neither overflows nor underflows.
constexpr double kMaxNumber = 1e300;
constexpr double kMinNumber = 1e-290;

constexpr std::size_t kMaxBins = 10'000;

struct Range {
    double from = 0.0;
    double to = 0.0;
};

/// 1, 2 or 5 times a power of ten.
struct RoundWidth {
    double digit = 1.0;
    int decade = 0;

    /// Divides by a power of ten instead of multiplying by its inverse: 3 · 0.1 is not 0.3.
    [[nodiscard]] double times(double count) const {
        return decade < 0 ? count * digit / std::pow(10.0, -decade)
                          : count * digit * std::pow(10.0, decade);
    }
};

/// From one multiple of their width to another.
struct RoundBins {
    RoundWidth width;
    double first = 0.0;
    double last = 0.0;

    [[nodiscard]] double count() const { return last - first; }
};

template <typename Condition>
std::vector<double> those_that(std::span<const double> values, Condition condition) {
    std::vector<double> some;
    std::ranges::copy_if(values, std::back_inserter(some), condition);
    return some;
}

/// Reorders the numbers, of which there is at least one.
double quantile_of(std::vector<double> &numbers, double fraction) {
    const double rank = std::ceil(fraction * static_cast<double>(numbers.size()));
    const auto wanted = numbers.begin() + static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
    std::nth_element(numbers.begin(), wanted, numbers.end());
    return *wanted;
}

Range covered_range(std::span<const double> values, Coverage coverage) {
    std::vector<double> usable =
        those_that(values, [](double value) { return std::abs(value) <= kMaxNumber; });
    if (usable.empty()) {
        return {};
    }
    const double outside = coverage == Coverage::all ? 0.0 : 0.001;
    const double from = quantile_of(usable, outside);
    return {from, quantile_of(usable, 1.0 - outside)};
}

Range widened_if_narrow(const Range &range) {
    const double size = std::max(std::abs(range.from), std::abs(range.to));
    if (range.to - range.from > std::max(1e-9 * size, kMinNumber)) {
        return range;
    }
    const double margin = size > kMinNumber ? 0.1 * size : 1.0;
    return {range.from - margin, range.to + margin};
}

/// The bins of a width that cover a range. Comparing multiples, not quotients, is exact where the
/// range ends on one.
RoundBins bins_around(const Range &range, const RoundWidth &width) {
    RoundBins bins{width, std::round(range.from / width.times(1.0)),
                   std::round(range.to / width.times(1.0))};
    bins.first += width.times(bins.first) > range.from ? -1.0 : 0.0; // + 0.0 turns −0 into 0
    bins.last += width.times(bins.last) < range.to ? 1.0 : 0.0;
    return bins;
}

/// The search ends: of bins wider than both ends are far from 0, at most two are needed.
RoundBins narrowest_round_bins(const Range &range, std::size_t max_bins) {
    const auto most = static_cast<double>(max_bins);
    const double narrowest = (range.to - range.from) / most;
    for (int decade = static_cast<int>(std::floor(std::log10(narrowest)));; ++decade) {
        for (const double digit : {1.0, 2.0, 5.0}) {
            const RoundBins bins = bins_around(range, {digit, decade});
            if (bins.count() <= most) {
                return bins;
            }
        }
    }
}

} // namespace

ValueHistogram histogram(std::span<const double> values, double from, double to, std::size_t bins) {
    SPRINGDRIVE_ASSERT(from < to && std::isfinite(to - from));
    SPRINGDRIVE_ASSERT(bins > 0);
    ValueHistogram result{.from = from, .to = to, .counts = std::vector<std::uint64_t>(bins)};
    std::vector<double> edges;
    for (std::size_t bin = 0; bin < bins; ++bin) {
        edges.push_back(result.edge(bin));
    }
    for (const double value : values) {
        if (std::isnan(value)) {
            ++result.not_a_number;
        } else if (value < from) {
            ++result.below;
        } else if (value > to) {
            ++result.above;
        } else { // a search, as a quotient would be rounded near an edge
            const auto next = std::ranges::upper_bound(edges, value);
            ++result.counts[static_cast<std::size_t>(next - edges.begin()) - 1];
        }
    }
    return result;
}

ValueHistogram automatic_histogram(std::span<const double> values, Coverage coverage,
                                   std::size_t max_bins) {
    SPRINGDRIVE_ASSERT(max_bins >= 2 && max_bins <= kMaxBins);
    const RoundBins bins =
        narrowest_round_bins(widened_if_narrow(covered_range(values, coverage)), max_bins);
    return histogram(values, bins.width.times(bins.first), bins.width.times(bins.last),
                     static_cast<std::size_t>(bins.count()));
}

double quantile(std::span<const double> values, double fraction) {
    SPRINGDRIVE_ASSERT(fraction >= 0.0 && fraction <= 1.0);
    std::vector<double> numbers =
        those_that(values, [](double value) { return !std::isnan(value); });
    return numbers.empty() ? std::numeric_limits<double>::quiet_NaN()
                           : quantile_of(numbers, fraction);
}

} // namespace springdrive::signals
