// A board's reports as a sequence: what each packet is, and how recent the newest report is.
//
// Lateness needs a common clock, which host and board do not have. A report's age by two clocks,
// now − measured, is wrong by a constant (and a drift of some 10^-4). Its least value within the
// last second belongs to reports that took the shortest way, so what exceeds that is lateness.
#pragma once

#include "device/core/haptic_device.h"
#include "device/usb/driver/board_port.h"

#include <cstdint>
#include <limits>

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

} // namespace springdrive::usb
