#include "device/core/motor/winding_guard.h"

#include <algorithm>
#include <cmath>

namespace springdrive::device {

double min_cold_residual_Ohm(const MotorParameters &motor, const AmplifierParameters &amplifier) {
    constexpr double kAnyPeriod_s = 1.0; // irrelevant, as the guard is read before its first update
    return motor.resistance_Ohm -
           WindingGuard(motor, amplifier.max_cancelled_Ohm, kAnyPeriod_s).max_cancelled_Ohm();
}

WindingGuard::WindingGuard(const MotorParameters &motor, double max_cancelled_Ohm, double period_s)
    : motor_(motor), amplifier_limit_Ohm_(max_cancelled_Ohm),
      coldest_(motor.thermal, kColdestAir_C, period_s), minimum_(coldest_),
      maximum_(motor.thermal, kWarmestAir_C, period_s) {}

void WindingGuard::set_period(double period_s) noexcept {
    coldest_.set_period(period_s);
    minimum_.set_period(period_s);
    maximum_.set_period(period_s);
}

void WindingGuard::update(double current_A, std::uint32_t missed_periods) noexcept {
    const bool known = std::isfinite(current_A) && std::isfinite(current_A_);
    const bool passed_zero = !(current_A * current_A_ > 0.0);
    const double min_A =
        known && !passed_zero ? std::min(std::abs(current_A), std::abs(current_A_)) : 0.0;
    const double max_A =
        known ? std::max(std::abs(current_A), std::abs(current_A_)) : motor_.peak_current_A;
    current_A_ = current_A;
    cool_through(missed_periods);
    minimum_.update(min_A * min_A * min_resistance_Ohm(motor_, minimum_.winding_C()));
    heat_through(missed_periods, max_A);
    maximum_.update(max_A * max_A * max_resistance_Ohm(motor_, maximum_.winding_C()));
}

/// Without heat; after a long gap, as cold as possible.
void WindingGuard::cool_through(std::uint32_t missed_periods) noexcept {
    if (missed_periods > kMaxAtOnce) {
        minimum_ = coldest_;
        return;
    }
    for (std::uint32_t i = 0; i < missed_periods; ++i) {
        minimum_.update(0.0);
    }
}

/// With the maximum possible heat; a long gap is processed over several ticks.
void WindingGuard::heat_through(std::uint32_t missed_periods, double max_A) noexcept {
    if (missed_periods > 0) {
        pending_periods_ += std::min(missed_periods, kMaxPending - pending_periods_);
        pending_max_A_ = std::max(pending_max_A_, max_A);
    }
    const std::uint32_t now = std::min(pending_periods_, kMaxAtOnce);
    for (std::uint32_t i = 0; i < now; ++i) {
        maximum_.update(pending_max_A_ * pending_max_A_ *
                        max_resistance_Ohm(motor_, maximum_.winding_C()));
    }
    pending_periods_ -= now;
    pending_max_A_ = pending_periods_ > 0 ? pending_max_A_ : 0.0;
}

double WindingGuard::max_cancelled_Ohm() const noexcept {
    const double permissible_Ohm =
        (1.0 - kMinResidualShare) * min_resistance_Ohm(motor_, minimum_.winding_C());
    return std::min(permissible_Ohm, amplifier_limit_Ohm_);
}

} // namespace springdrive::device
