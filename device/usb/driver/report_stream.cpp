#include "device/usb/driver/report_stream.h"

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

} // namespace springdrive::usb
