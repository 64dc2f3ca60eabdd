#include "device/usb/driver/delay_meter.h"

#include <algorithm>
#include <numeric>

namespace springdrive::usb {

void RecentTimes::take(double value_s) noexcept {
    if (next_ == 0) {
        largest_before_s_ = largest_s_;
        largest_s_ = value_s;
    }
    largest_s_ = std::max(largest_s_, value_s);
    value_s_[next_] = value_s;
    next_ = (next_ + 1) % kCount;
    count_ = std::min(count_ + 1, kCount);
}

double RecentTimes::mean_s() const noexcept {
    return count_ == 0 ? 0.0
                       : std::accumulate(value_s_.data(), value_s_.data() + count_, 0.0) /
                             static_cast<double>(count_);
}

void DelayMeter::sent(std::uint32_t number, std::uint32_t measured_at_us, bool is_first,
                      double now_s) noexcept {
    slot(number) = {number, measured_at_us, now_s, true, is_first, true};
}

std::optional<double> DelayMeter::take(const Report &report, double arrived_s) noexcept {
    if (!report.has_command) {
        return std::nullopt;
    }
    Sent &command = slot(report.command_number);
    if (command.number != report.command_number) {
        return std::nullopt; // not of this connection
    }
    if (command.counts_for_delay && report.applied_after_us != kNotApplied) {
        command.counts_for_delay = false;
        delay_.take(1e-6 * (difference(report.command_arrived_at_us, command.measured_at_us) +
                            static_cast<double>(report.applied_after_us)));
    }
    if (!command.counts_for_round_trip) {
        return std::nullopt;
    }
    command.counts_for_round_trip = false;
    const double waited_s = 1e-6 * difference(report.measured_at_us, report.command_arrived_at_us);
    const double round_trip_s = arrived_s - command.sent_s - waited_s;
    if (!(round_trip_s > 0.0)) {
        return std::nullopt; // the board's time is not real time
    }
    round_trip_.take(round_trip_s);
    return round_trip_s;
}

} // namespace springdrive::usb
