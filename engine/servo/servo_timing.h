// The servo's timing: its deadlines, quantiles of durations, and the statistics of a run.
#pragma once

#include "engine/servo/servo_sample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace springdrive::servo {

// Absolute deadlines that do not drift, and the handling of missed ones.
//
//   deadline n    n      n+1     n+2     n+3
//   ──────────────|───────|───────|───────|──►
//   tick           ▓▓▓▓▓▓▓▓▓▓▓▓▓           ▓▓▓       overrun: n+1 and n+2 are missed, n+3 is next
//
// Missed deadlines are skipped; ticks never run back to back to catch up.

/// Times are nanoseconds of one clock since the start. RT-safe.
class Deadlines {
public:
    explicit Deadlines(double rate_hz) : rate_hz_(rate_hz) {}

    /// When the next tick is due [ns]; each deadline is rounded individually, so errors do not
    /// accumulate.
    [[nodiscard]] std::int64_t next_ns() const { return at_ns(next_); }

    /// Call when a tick begins: deadlines that passed while its thread slept are missed.
    void begin(std::int64_t now_ns) noexcept {
        pass_over(now_ns);
        if (missed_ == 0) {
            in_a_row_ = 0;
        }
    }

    /// Call when it ends: the next deadline is the first one in the future.
    void end(std::int64_t now_ns) noexcept {
        missed_ = 0;
        ++next_;
        if (now_ns > at_ns(next_)) {
            pass_over(now_ns);
            ++next_;
            ++missed_;
            ++in_a_row_;
        }
    }

    /// Missed since the previous tick, as of `begin`.
    [[nodiscard]] std::uint32_t missed() const { return missed_; }

    /// Missed in a row: including those before earlier ticks, back to a tick that missed none.
    [[nodiscard]] std::uint32_t missed_in_a_row() const { return in_a_row_; }

private:
    [[nodiscard]] std::int64_t at_ns(std::int64_t index) const {
        return std::llround(1e9 * static_cast<double>(index) / rate_hz_);
    }

    /// Skips to the last deadline that is not after `now_ns`.
    void pass_over(std::int64_t now_ns) noexcept {
        const auto last =
            static_cast<std::int64_t>(std::floor(static_cast<double>(now_ns) * 1e-9 * rate_hz_));
        if (last > next_) {
            const auto passed = static_cast<std::uint32_t>(last - next_);
            missed_ += passed;
            in_a_row_ += passed;
            next_ = last;
        }
    }

    double rate_hz_;
    std::int64_t next_ = 1;
    std::uint32_t missed_ = 0;
    std::uint32_t in_a_row_ = 0;
};

/// Quantiles of durations without storing them: a histogram with logarithmic bins. Bins are 1/64
/// octave wide and assumed to be evenly filled, so a quantile is within 1.1 % of the true one.
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
        const double requested = fraction * static_cast<double>(count_);
        double before = 0.0;
        // The last bin has no upper bound.
        for (std::size_t bin = 0; bin + 1 < bins_.size(); ++bin) {
            const auto within = static_cast<double>(bins_[bin]);
            if (within > 0.0 && before + within >= requested) {
                const double lower_s = lower_bound_s(bin);
                const double share = std::max(0.0, requested - before) / within;
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

/// Timing statistics of a servo, accumulated from its samples by their reader.
class ServoStatistics {
public:
    void add(const ServoSample &sample) noexcept {
        ++ticks_;
        missed_ += sample.missed_deadlines;
        add_if_known(period_, sample.period_s);
        add_if_known(lateness_, sample.lateness_s);
        add_if_known(read_, sample.read_s);
        add_if_known(compute_, sample.compute_s);
        add_if_known(write_, sample.write_s);
    }

    [[nodiscard]] std::uint64_t ticks() const { return ticks_; }
    [[nodiscard]] std::uint64_t missed_deadlines() const { return missed_; }

    /// From the start of a tick to the start of the next.
    [[nodiscard]] const DurationHistogram &period() const { return period_; }
    /// From a tick's deadline to its start: the jitter.
    [[nodiscard]] const DurationHistogram &lateness() const { return lateness_; }
    /// Duration of reading the device.
    [[nodiscard]] const DurationHistogram &read() const { return read_; }
    /// From the measurement to the command computed from it.
    [[nodiscard]] const DurationHistogram &compute() const { return compute_; }
    /// Duration of writing to the device.
    [[nodiscard]] const DurationHistogram &write() const { return write_; }

private:
    static void add_if_known(DurationHistogram &histogram, double duration_s) noexcept {
        if (!std::isnan(duration_s)) {
            histogram.add(duration_s);
        }
    }

    std::uint64_t ticks_ = 0;
    std::uint64_t missed_ = 0;
    DurationHistogram period_;
    DurationHistogram lateness_;
    DurationHistogram read_;
    DurationHistogram compute_;
    DurationHistogram write_;
};

} // namespace springdrive::servo
