// The servo's timing: absolute deadlines that do not drift, and the handling of missed ones.
//
//   deadline n    n      n+1     n+2     n+3
//   ──────────────|───────|───────|───────|──►
//   tick           ▓▓▓▓▓▓▓▓▓▓▓▓▓           ▓▓▓       overrun: n+1 and n+2 are missed, n+3 is next
//
// Missed deadlines are skipped; ticks never run back to back to catch up.
#pragma once

#include <cmath>
#include <cstdint>

namespace springdrive::servo {

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

} // namespace springdrive::servo
