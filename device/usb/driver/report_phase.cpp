#include "device/usb/driver/report_phase.h"

#include "device/usb/protocol.h"

#include <algorithm>

namespace springdrive::usb {

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
