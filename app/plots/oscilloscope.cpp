#include "app/plots/oscilloscope.h"

#include "base/assertions.h"

#include <Eigen/Core>
#include <unsupported/Eigen/FFT>

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <utility>

namespace springdrive::signals {

namespace {

constexpr std::size_t kMinSegment = 64;

// Of the periodic Hann window: mean 1/2, mean square 3/8. Their ratio (3/8)/(1/2)² is the noise
// bandwidth.
constexpr double kWindowMean = 0.5;
constexpr double kNoiseBandwidthBins = 1.5;

std::span<const double> longest_finite_run(std::span<const double> values) {
    const auto is_finite = [](double value) { return std::isfinite(value); };
    std::span<const double> longest;
    auto begin = values.begin();
    while (begin != values.end()) {
        const auto end = std::find_if_not(begin, values.end(), is_finite);
        const std::span<const double> run(begin, end);
        longest = run.size() > longest.size() ? run : longest;
        begin = std::find_if(end, values.end(), is_finite);
    }
    return longest;
}

/// 8 segments that overlap by half are 4 1/2 segments long.
std::size_t segment_length(std::size_t samples) {
    return std::max(std::bit_floor(2 * samples / 9), kMinSegment);
}

std::size_t segment_count(std::size_t samples, std::size_t length) {
    return (samples - length) / (length / 2) + 1;
}

Eigen::ArrayXd hann_window(Eigen::Index length) {
    const double turn_rad = 2.0 * std::numbers::pi / static_cast<double>(length);
    return Eigen::ArrayXd::NullaryExpr(length, [turn_rad](Eigen::Index i) {
        return 0.5 - 0.5 * std::cos(turn_rad * static_cast<double>(i));
    });
}

/// The mean of |X|² over segments, for the bins from 0 to half the sample rate.
Eigen::ArrayXd mean_power(const Eigen::ArrayXd &values, Eigen::Index length, std::size_t segments) {
    const Eigen::ArrayXd window = hann_window(length);
    Eigen::FFT<double> fft;
    fft.SetFlag(fft.HalfSpectrum);
    Eigen::VectorXcd transform;
    Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(length / 2 + 1);
    for (std::size_t i = 0; i < segments; ++i) {
        const Eigen::Index start = static_cast<Eigen::Index>(i) * (length / 2);
        const Eigen::VectorXd windowed = window * values.segment(start, length);
        fft.fwd(transform, windowed);
        sum += transform.array().abs2();
    }
    return sum / static_cast<double>(segments);
}

/// 2 for a bin, which stands for ±f; 1 at both ends, where the two are one.
Eigen::ArrayXd sides(Eigen::Index bins) {
    Eigen::ArrayXd counts = Eigen::ArrayXd::Constant(bins, 2.0);
    counts[0] = 1.0;
    counts[bins - 1] = 1.0;
    return counts;
}

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

/// The smallest number that at least a share `fraction` of all does not exceed. Reorders them, of
/// which there is at least one.
double quantile(std::vector<double> &numbers, double fraction) {
    const double rank = std::ceil(fraction * static_cast<double>(numbers.size()));
    const auto nth = numbers.begin() + static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
    std::nth_element(numbers.begin(), nth, numbers.end());
    return *nth;
}

Range covered_range(std::span<const double> values) {
    std::vector<double> usable;
    std::ranges::copy_if(values, std::back_inserter(usable),
                         [](double value) { return std::abs(value) <= kMaxNumber; });
    if (usable.empty()) {
        return {};
    }
    constexpr double kOutside = 0.001; // at each end
    const double from = quantile(usable, kOutside);
    return {from, quantile(usable, 1.0 - kOutside)};
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

Spectrum amplitude_spectrum(std::span<const double> values, double sample_rate_hz) {
    SPRINGDRIVE_ASSERT(sample_rate_hz > 0.0);
    const std::span<const double> run = longest_finite_run(values);
    if (run.size() < kMinSegment) {
        return {};
    }
    // A copy: in place, the order of Eigen's sums depends on the alignment.
    Eigen::ArrayXd signal =
        Eigen::Map<const Eigen::ArrayXd>(run.data(), static_cast<Eigen::Index>(run.size()));
    signal -= signal.mean();
    const std::size_t length = segment_length(run.size());
    const std::size_t segments = segment_count(run.size(), length);
    const double bin_Hz = sample_rate_hz / static_cast<double>(length);
    const double resolution_Hz = kNoiseBandwidthBins * bin_Hz;

    // The two sides of a sine add up as amplitudes, those of noise as powers.
    const Eigen::ArrayXd power = mean_power(signal, static_cast<Eigen::Index>(length), segments);
    const Eigen::ArrayXd one_side = power.sqrt() / (kWindowMean * static_cast<double>(length));
    const Eigen::ArrayXd amplitude = sides(power.size()) * one_side;
    const Eigen::ArrayXd density = (sides(power.size()) / resolution_Hz).sqrt() * one_side;
    return {.bin_Hz = bin_Hz,
            .amplitude = {amplitude.begin(), amplitude.end()},
            .density_per_rtHz = {density.begin(), density.end()},
            .segments = segments,
            .resolution_Hz = resolution_Hz};
}

ValueHistogram histogram(std::span<const double> values, std::size_t max_bins) {
    SPRINGDRIVE_ASSERT(max_bins >= 2 && max_bins <= kMaxBins);
    const RoundBins bins = narrowest_round_bins(widened_if_narrow(covered_range(values)), max_bins);
    ValueHistogram result{.from = bins.width.times(bins.first),
                          .to = bins.width.times(bins.last),
                          .counts =
                              std::vector<std::uint64_t>(static_cast<std::size_t>(bins.count()))};
    std::vector<double> edges;
    for (std::size_t bin = 0; bin < result.counts.size(); ++bin) {
        edges.push_back(result.edge(bin));
    }
    for (const double value : values) {
        if (value < result.from) {
            ++result.below;
        } else if (value > result.to) {
            ++result.above;
        } else if (!std::isnan(value)) { // a search, as a quotient would be rounded near an edge
            const auto next = std::ranges::upper_bound(edges, value);
            ++result.counts[static_cast<std::size_t>(next - edges.begin()) - 1];
        }
    }
    return result;
}

bool EdgeDetector::take(double value) noexcept {
    if (std::isnan(value)) {
        return false;
    }
    const double before = std::exchange(last_, value);
    if (std::isnan(before)) {
        return false;
    }
    const bool rises = before <= condition_.level && value > condition_.level;
    const bool falls = before > condition_.level && value <= condition_.level;
    switch (condition_.edge) {
    case TriggerEdge::rising:
        return rises;
    case TriggerEdge::falling:
        return falls;
    case TriggerEdge::either:
        return rises || falls;
    case TriggerEdge::change:
        return value != before;
    }
    return false;
}

Trigger::Trigger(const TriggerSettings &settings) : settings_(settings) {
    SPRINGDRIVE_ASSERT(settings.pre_s >= 0.0);
    SPRINGDRIVE_ASSERT(settings.post_s >= 0.0);
}

void Trigger::take(double time_s, bool fired) noexcept {
    if (state_ == TriggerState::waiting && fired) {
        state_ = TriggerState::collecting;
        event_s_ = time_s;
    }
    if (state_ == TriggerState::collecting && time_s >= end_s()) {
        state_ = TriggerState::complete;
    }
}

void Trigger::proceed() noexcept {
    if (state_ == TriggerState::complete && settings_.mode == TriggerMode::repeating) {
        state_ = TriggerState::waiting;
    }
}

std::optional<TimeWindow> Trigger::window() const noexcept {
    if (state_ != TriggerState::complete) {
        return std::nullopt;
    }
    return TimeWindow{event_s_ - settings_.pre_s, end_s()};
}

} // namespace springdrive::signals
