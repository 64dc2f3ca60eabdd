// The servo's beat: absolute deadlines that do not drift, and what becomes of those that were
// missed.
//
//   deadline n    n      n+1     n+2     n+3
//   ──────────────|───────|───────|───────|──►
//   tick           ▓▓▓▓▓▓▓▓▓▓▓▓▓           ▓▓▓       too long: n+1 and n+2 are missed, n+3 is next
//
// What was missed is passed over; a tick never runs twice in a row to catch up.
#pragma once

#include <cmath>
#include <cstdint>

namespace springdrive::servo {

/// Counts in nanoseconds of one clock since the start. RT-safe.
class Deadlines {
public:
    explicit Deadlines(double rate_hz) : rate_hz_(rate_hz) {}

    /// When the next tick is due [ns]; each is rounded by itself, so errors do not add up.
    [[nodiscard]] std::int64_t next_ns() const { return at_ns(next_); }

    /// A tick begins: deadlines that passed while its thread slept are missed.
    void begin(std::int64_t now_ns) noexcept {
        pass_over(now_ns);
        if (missed_ == 0) {
            in_a_row_ = 0;
        }
    }

    /// It ends: the next deadline is the first that is still ahead.
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

    /// Missed since the tick before, as of `begin`.
    [[nodiscard]] std::uint32_t missed() const { return missed_; }

    /// With those before the ticks before, back to one that missed none.
    [[nodiscard]] std::uint32_t missed_in_a_row() const { return in_a_row_; }

private:
    [[nodiscard]] std::int64_t at_ns(std::int64_t index) const {
        return std::llround(1e9 * static_cast<double>(index) / rate_hz_);
    }

    /// Moves on to the last deadline that is not ahead of now.
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
