// A board's reports as a sequence, and what their times say: how recent the newest one is, how long
// a command takes, and when the board shall measure the next report.
#pragma once

#include "device/core/haptic_device.h"
#include "device/usb/driver/board_port.h"
#include "device/usb/protocol.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

namespace springdrive::usb {

/// What became of packets and ticks, since the connection.
struct StreamCounts {
    std::uint64_t reports = 0;  ///< valid and new
    std::uint64_t lost = 0;     ///< numbers that are missing
    std::uint64_t repeated = 0; ///< packets with the number of the newest report
    std::uint64_t stale = 0;    ///< packets with an older number
    std::uint64_t corrupt = 0;  ///< packets that are no valid report
    std::uint64_t late = 0;     ///< ticks whose newest report was measured for an earlier one
    std::uint64_t absent = 0;   ///< ticks without a new report
    FrameStatus last_damage = FrameStatus::ok; ///< of the last corrupt packet
};

/// The reports as a sequence: what each packet is, and how recent the newest report is.
///
/// Lateness needs a common clock, which host and board do not have. A report's age by two clocks,
/// now − measured, is wrong by a constant (and a drift of some 10^-4). Its least value within the
/// last second belongs to reports that took the shortest way, so what exceeds that is lateness.
///
/// RT-safe throughout.
class ReportStream {
public:
    /// A new connection: the next report is the first.
    void begin() noexcept;

    /// @return whether it is a new report
    bool take(const Packet &packet) noexcept;

    /// How the newest report arrived for a tick that is reading now. Packets since the last call
    /// count.
    /// @param period_s  T; with `is_timed` false, no report is late
    [[nodiscard]] device::Arrival settle(double now_s, double period_s, bool is_timed) noexcept;

    [[nodiscard]] bool has_report() const noexcept { return has_report_; }
    [[nodiscard]] const Report &newest() const noexcept { return newest_; }
    /// Of the newest report: its number and board time, extended to 64 bits.
    [[nodiscard]] std::uint64_t number() const noexcept { return number_; }
    [[nodiscard]] double measured_s() const noexcept {
        return 1e-6 * static_cast<double>(measured_us_);
    }
    /// Whether the board lost its state since `begin`: its counts then have another zero, and no
    /// report is taken any more.
    [[nodiscard]] bool has_restarted() const noexcept { return has_restarted_; }
    [[nodiscard]] const StreamCounts &counts() const noexcept { return counts_; }
    void forget_counts() noexcept { counts_ = {}; }

private:
    /// The least of values within the last one to two windows.
    class RecentLeast {
    public:
        void take(double value, double now_s) noexcept;
        [[nodiscard]] double value() const noexcept { return min_ < before_ ? min_ : before_; }

    private:
        static constexpr double kWindow_s = 1.0;
        double min_ = std::numeric_limits<double>::infinity();
        double before_ = std::numeric_limits<double>::infinity();
        double began_s_ = 0.0;
        bool has_begun_ = false;
    };

    void accept(const Report &report) noexcept;

    bool has_report_ = false;
    Report newest_;
    std::uint64_t number_ = 0;
    std::uint64_t measured_us_ = 0;
    bool had_command_ = false;
    bool has_restarted_ = false;
    RecentLeast min_age_s_;
    StreamCounts counts_;
    bool is_new_ = false;      ///< a report arrived since the last `settle`
    bool is_repeated_ = false; ///< at least one old report did
    bool is_corrupt_ = false;  ///< at least one invalid packet did
};

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

/// Measures d as the loop runs, on the board's clock alone:
///
///   d T = (arrived + applied after, of a command) − (measured at, of the report it was computed
///   from)
///
/// and on the host's clock the round trip of packets: from the command's departure to the arrival
/// of the first report that knows it, without the time that the board waited between the two.
///
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

/// When, after a command's arrival, the board shall measure the next report, so that the report
/// reaches the host just before the next tick: d is then little more than one computation and one
/// round trip, whatever the clocks of host and board do.
///
///   tick ──c──► command ──way──► board ──report after──► measures ──way──► host ──margin──► tick
///
/// RT-safe throughout.
class ReportPhase {
public:
    /// @param round_trip_s  of one command and its report
    void take(double round_trip_s) noexcept;

    /// @param since_tick_s  from the tick's start to the command's departure
    [[nodiscard]] std::uint16_t report_after_us(double since_tick_s,
                                                double period_s) const noexcept;

private:
    /// Between a report's arrival and the tick, for the host's own jitter.
    static constexpr double kMargin_s = 60e-6;
    static constexpr double kShare = 0.95; ///< of round trips that shall be shorter
    static constexpr double kStep_s = 2e-6;

    double usual_s_ = 0.0; ///< `kShare` of round trips are shorter
    bool has_begun_ = false;
};

} // namespace springdrive::usb
