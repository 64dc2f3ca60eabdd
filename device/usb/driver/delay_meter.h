// Measures d as the loop runs, on the board's clock alone:
//
//   d T = (arrived + applied after, of a command) − (measured at, of the report it was computed
//   from)
//
// and on the host's clock the round trip of packets: from the command's departure to the arrival of
// the first report that knows it, without the time that the board waited between the two.
#pragma once

#include "device/usb/protocol.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace springdrive::usb {

/// Mean and largest of the latest values.
class RecentTimes {
public:
    void take(double value_s) noexcept;
    [[nodiscard]] double mean_s() const noexcept;
    /// Of the last kCount to 2 kCount values.
    [[nodiscard]] double largest_s() const noexcept {
        return largest_s_ > largest_before_s_ ? largest_s_ : largest_before_s_;
    }

private:
    static constexpr std::size_t kCount = 256; ///< a quarter of a second at 1 kHz
    std::array<double, kCount> value_s_{};
    std::size_t next_ = 0;
    std::size_t count_ = 0;
    double largest_s_ = 0.0;
    double largest_before_s_ = 0.0;
};

/// RT-safe throughout.
class DelayMeter {
public:
    /// A command that leaves now.
    /// @param measured_at_us  board time of the report it was computed from
    /// @param is_first  whether no command before was computed from this report
    void sent(std::uint32_t number, std::uint32_t measured_at_us, bool is_first,
              double now_s) noexcept;

    /// A new report.
    /// @return a round trip, if this report completes one [s]
    std::optional<double> take(const Report &report, double arrived_s) noexcept;

    /// Whether a command with this number was among the last ones.
    [[nodiscard]] bool has_sent(std::uint32_t number) const noexcept {
        const Sent &sent = sent_[number % kRemembered];
        return sent.number == number && sent.is_known;
    }

    [[nodiscard]] const RecentTimes &delay() const noexcept { return delay_; }
    [[nodiscard]] const RecentTimes &round_trip() const noexcept { return round_trip_; }

private:
    struct Sent {
        std::uint32_t number = 0;
        std::uint32_t measured_at_us = 0;
        double sent_s = 0.0;
        bool is_known = false;
        bool counts_for_delay = false;
        bool counts_for_round_trip = false;
    };

    static constexpr std::size_t kRemembered = 64; ///< commands under way; a power of two
    [[nodiscard]] Sent &slot(std::uint32_t number) noexcept { return sent_[number % kRemembered]; }

    std::array<Sent, kRemembered> sent_{};
    RecentTimes delay_;
    RecentTimes round_trip_;
};

} // namespace springdrive::usb
