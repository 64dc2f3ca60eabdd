// Quantiles of durations without storing them: a histogram with logarithmic bins.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace springdrive::servo {

/// Bins are 1/64 octave wide and assumed to be evenly filled, so a quantile is within 1.1 % of the
/// true one.
class DurationHistogram {
public:
    /// RT-safe.
    void add(double duration_s) noexcept {
        const double octaves = std::log2(std::max(duration_s, kMin_s) / kMin_s);
        const auto bin = static_cast<std::size_t>(octaves * kBinsPerOctave);
        ++bins_[std::min(bin, bins_.size() - 1)];
        ++count_;
        sum_s_ += duration_s;
        longest_s_ = std::max(longest_s_, duration_s);
    }

    /// The duration that a share `fraction` of all durations does not exceed [s]; 0 if there are
    /// none.
    [[nodiscard]] double quantile_s(double fraction) const noexcept {
        const double wanted = fraction * static_cast<double>(count_);
        double before = 0.0;
        // The last bin has no upper bound.
        for (std::size_t bin = 0; bin + 1 < bins_.size(); ++bin) {
            const auto within = static_cast<double>(bins_[bin]);
            if (within > 0.0 && before + within >= wanted) {
                const double lower_s = lower_bound_s(bin);
                const double share = std::max(0.0, wanted - before) / within;
                return std::min(lower_s + share * (lower_bound_s(bin + 1) - lower_s), longest_s_);
            }
            before += within;
        }
        return longest_s_;
    }

    [[nodiscard]] double mean_s() const noexcept {
        return count_ == 0 ? 0.0 : sum_s_ / static_cast<double>(count_);
    }
    [[nodiscard]] double longest_s() const noexcept { return longest_s_; }
    [[nodiscard]] std::uint64_t count() const noexcept { return count_; }

private:
    [[nodiscard]] static double lower_bound_s(std::size_t bin) noexcept {
        return kMin_s * std::exp2(static_cast<double>(bin) / kBinsPerOctave);
    }

    static constexpr double kMin_s = 10e-9;
    static constexpr double kBinsPerOctave = 64.0;

    std::array<std::uint64_t, std::size_t{64} * 30> bins_{}; ///< up to 10 s
    std::uint64_t count_ = 0;
    double sum_s_ = 0.0;
    double longest_s_ = 0.0;
};

} // namespace springdrive::servo
