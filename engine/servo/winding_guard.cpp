#include "engine/servo/winding_guard.h"

#include <algorithm>
#include <cmath>

namespace springdrive {

double least_cold_residual_Ohm(const MotorParameters &motor, const AmplifierParameters &amplifier) {
    constexpr double kAnyPeriod_s = 1.0; // of a guard that is asked before its first update
    return motor.resistance_Ohm -
           WindingGuard(motor, amplifier.greatest_cancelled_Ohm, kAnyPeriod_s)
               .greatest_cancelled_Ohm();
}

WindingGuard::WindingGuard(const MotorParameters &motor, double greatest_cancelled_Ohm,
                           double period_s)
    : motor_(motor), amplifier_limit_Ohm_(greatest_cancelled_Ohm),
      least_(motor.thermal, kColdestAir_C, period_s),
      greatest_(motor.thermal, kWarmestAir_C, period_s) {}

void WindingGuard::update(double current_A) noexcept {
    const bool known = std::isfinite(current_A) && std::isfinite(current_A_);
    const bool passed_zero = !(current_A * current_A_ > 0.0);
    const double least_A =
        known && !passed_zero ? std::min(std::abs(current_A), std::abs(current_A_)) : 0.0;
    const double most_A =
        known ? std::max(std::abs(current_A), std::abs(current_A_)) : motor_.peak_current_A;
    current_A_ = current_A;
    least_.update(least_A * least_A * least_resistance_Ohm(motor_, least_.winding_C()));
    greatest_.update(most_A * most_A * greatest_resistance_Ohm(motor_, greatest_.winding_C()));
}

double WindingGuard::greatest_cancelled_Ohm() const noexcept {
    const double bearable_Ohm =
        (1.0 - kLeastResidualShare) * least_resistance_Ohm(motor_, least_.winding_C());
    return std::min(bearable_Ohm, amplifier_limit_Ohm_);
}

} // namespace springdrive
