#include "device/usb/driver/report_stream.h"

#include "device/usb/protocol.h"

#include <algorithm>
#include <numeric>

namespace springdrive::usb {

using device::Arrival;

void ReportStream::RecentLeast::take(double value, double now_s) noexcept {
    if (!has_begun_ || now_s - began_s_ >= kWindow_s) {
        has_begun_ = true;
        began_s_ = now_s;
        before_ = min_;
        min_ = value;
    } else if (value < min_) {
        min_ = value;
    }
}

void ReportStream::begin() noexcept { *this = ReportStream(); }

bool ReportStream::take(const Packet &packet) noexcept {
    Report report;
    if (const FrameStatus status = decode(packet.data.data(), packet.size, report);
        status != FrameStatus::ok) {
        ++counts_.corrupt;
        counts_.last_damage = status;
        is_corrupt_ = true;
        return false;
    }
    // A restarted board has accepted no command yet; its counts have another zero.
    has_restarted_ = has_restarted_ || (had_command_ && !report.has_command);
    if (has_restarted_) {
        return false;
    }
    const std::int32_t newer = has_report_ ? difference(report.number, newest_.number) : 1;
    if (newer <= 0) {
        ++(newer == 0 ? counts_.repeated : counts_.stale);
        is_repeated_ = true;
        return false;
    }
    if (has_report_ && difference(report.measured_at_us, newest_.measured_at_us) < 0) {
        has_restarted_ = true; // a clock that goes back is another one
        return false;
    }
    if (newer > 1) {
        counts_.lost += static_cast<std::uint64_t>(newer) - 1U;
    }
    accept(report);
    return true;
}

void ReportStream::accept(const Report &report) noexcept {
    if (has_report_) {
        number_ += static_cast<std::uint64_t>(
            static_cast<std::int64_t>(difference(report.number, newest_.number)));
        measured_us_ += static_cast<std::uint64_t>(
            static_cast<std::int64_t>(difference(report.measured_at_us, newest_.measured_at_us)));
    } else {
        number_ = report.number;
        measured_us_ = report.measured_at_us;
    }
    newest_ = report;
    has_report_ = true;
    had_command_ = had_command_ || report.has_command;
    is_new_ = true;
    ++counts_.reports;
}

Arrival ReportStream::settle(double now_s, double period_s, bool is_timed) noexcept {
    const bool is_new = is_new_;
    const bool is_repeated = is_repeated_;
    const bool is_corrupt = is_corrupt_;
    is_new_ = false;
    is_repeated_ = false;
    is_corrupt_ = false;
    if (!is_new) {
        ++counts_.absent;
        return is_corrupt ? Arrival::corrupt : is_repeated ? Arrival::repeated : Arrival::absent;
    }
    const double age_s = now_s - measured_s();
    min_age_s_.take(age_s, now_s);
    if (is_timed && age_s - min_age_s_.value() > period_s) {
        ++counts_.late;
        return Arrival::late;
    }
    return Arrival::fresh;
}

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

/// Follows the quantile: a step up weighs as much as all the steps down.
void ReportPhase::take(double round_trip_s) noexcept {
    if (!has_begun_) {
        usual_s_ = round_trip_s;
        has_begun_ = true;
        return;
    }
    usual_s_ += round_trip_s > usual_s_ ? kShare / (1.0 - kShare) * kStep_s : -kStep_s;
    usual_s_ = std::max(usual_s_, 0.0);
}

std::uint16_t ReportPhase::report_after_us(double since_tick_s, double period_s) const noexcept {
    const double after_s = period_s - kMargin_s - since_tick_s - usual_s_;
    return static_cast<std::uint16_t>(
        std::clamp(1e6 * after_s, 0.0, static_cast<double>(kMaxReportPeriod_us)));
}

} // namespace springdrive::usb
