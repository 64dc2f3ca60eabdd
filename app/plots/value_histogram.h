// How often a signal has which values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace springdrive::signals {

/// Bins of equal width. A value on the edge of two bins counts in the upper one, at `to` in the
/// last one. Every value is counted once: in a bin, below, above or as not a number.
struct ValueHistogram {
    double from = 0.0;
    double to = 0.0;
    std::vector<std::uint64_t> counts; ///< of each bin
    std::uint64_t below = 0;
    std::uint64_t above = 0;
    std::uint64_t not_a_number = 0;

    [[nodiscard]] double bin_width() const {
        return (to - from) / static_cast<double>(counts.size());
    }
    /// Where a bin begins.
    [[nodiscard]] double edge(std::size_t bin) const {
        return from + static_cast<double>(bin) * bin_width();
    }
};

/// @pre from < to, with a finite difference; at least one bin
[[nodiscard]] ValueHistogram histogram(std::span<const double> values, double from, double to,
                                       std::size_t bins);

/// Which values an automatic range covers.
enum class Coverage : std::uint8_t {
    all,  ///< every finite value
    most, ///< from their 0.1 % to their 99.9 % quantile, so that outliers do not hide the rest
};

/// With a range of its own choice: bins are 1, 2 or 5 times a power of ten wide, their edges
/// multiples of that, and they are as narrow as `max_bins` allows. Where all values are equal, or
/// differ by less than 1e-9 of their size, the range is widened by 10 % to both sides, around 0 by
/// 1. Without values it is that around 0. Magnitudes above 1e300 are treated like infinities.
/// @pre 2 to 10'000 bins
[[nodiscard]] ValueHistogram automatic_histogram(std::span<const double> values, Coverage coverage,
                                                 std::size_t max_bins);

/// The smallest value that at least a share `fraction` of all values does not exceed, so one of
/// them. NaN is ignored, and returned if there is nothing else. @pre 0 <= fraction <= 1
[[nodiscard]] double quantile(std::span<const double> values, double fraction);

} // namespace springdrive::signals
