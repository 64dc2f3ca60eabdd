// When, after a command's arrival, the board shall measure the next report, so that the report
// reaches the host just before the next tick: d is then little more than one computation and one
// round trip, whatever the clocks of host and board do.
//
//   tick ──c──► command ──way──► board ──report after──► measures ──way──► host ──margin──► tick
#pragma once

#include <cstdint>

namespace springdrive::usb {

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
