#include "device/core/motor/winding_guard.h"

#include <algorithm>
#include <cmath>

namespace springdrive::device {

double least_cold_residual_Ohm(const MotorParameters &motor, const AmplifierParameters &amplifier) {
    constexpr double kAnyPeriod_s = 1.0; // irrelevant, as the guard is read before its first update
    return motor.resistance_Ohm -
           WindingGuard(motor, amplifier.greatest_cancelled_Ohm, kAnyPeriod_s)
               .greatest_cancelled_Ohm();
}

WindingGuard::WindingGuard(const MotorParameters &motor, double greatest_cancelled_Ohm,
                           double period_s)
    : motor_(motor), amplifier_limit_Ohm_(greatest_cancelled_Ohm),
      coldest_(motor.thermal, kColdestAir_C, period_s), least_(coldest_),
      greatest_(motor.thermal, kWarmestAir_C, period_s) {}

void WindingGuard::set_period(double period_s) noexcept {
    coldest_.set_period(period_s);
    least_.set_period(period_s);
    greatest_.set_period(period_s);
}

void WindingGuard::update(double current_A, std::uint32_t missed_periods) noexcept {
    const bool known = std::isfinite(current_A) && std::isfinite(current_A_);
    const bool passed_zero = !(current_A * current_A_ > 0.0);
    const double least_A =
        known && !passed_zero ? std::min(std::abs(current_A), std::abs(current_A_)) : 0.0;
    const double most_A =
        known ? std::max(std::abs(current_A), std::abs(current_A_)) : motor_.peak_current_A;
    current_A_ = current_A;
    cool_through(missed_periods);
    least_.update(least_A * least_A * least_resistance_Ohm(motor_, least_.winding_C()));
    heat_through(missed_periods, most_A);
    greatest_.update(most_A * most_A * greatest_resistance_Ohm(motor_, greatest_.winding_C()));
}

/// Without heat; after a long gap, as cold as possible.
void WindingGuard::cool_through(std::uint32_t missed_periods) noexcept {
    if (missed_periods > kMostAtOnce) {
        least_ = coldest_;
        return;
    }
    for (std::uint32_t i = 0; i < missed_periods; ++i) {
        least_.update(0.0);
    }
}

/// With the maximum possible heat; a long gap is processed over several ticks.
void WindingGuard::heat_through(std::uint32_t missed_periods, double most_A) noexcept {
    if (missed_periods > 0) {
        pending_ += std::min(missed_periods, kMaxPending - pending_);
        pending_max_A_ = std::max(pending_max_A_, most_A);
    }
    const std::uint32_t now = std::min(pending_, kMostAtOnce);
    for (std::uint32_t i = 0; i < now; ++i) {
        greatest_.update(pending_max_A_ * pending_max_A_ *
                         greatest_resistance_Ohm(motor_, greatest_.winding_C()));
    }
    pending_ -= now;
    pending_max_A_ = pending_ > 0 ? pending_max_A_ : 0.0;
}

double WindingGuard::greatest_cancelled_Ohm() const noexcept {
    const double permissible_Ohm =
        (1.0 - kLeastResidualShare) * least_resistance_Ohm(motor_, least_.winding_C());
    return std::min(permissible_Ohm, amplifier_limit_Ohm_);
}

} // namespace springdrive::device
