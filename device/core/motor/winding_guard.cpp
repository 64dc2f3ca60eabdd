#include "device/core/motor/winding_guard.h"

#include <algorithm>
#include <cmath>

namespace springdrive::device {

namespace {

/// What a sensor's gain may change after an observation, as a share of R.
constexpr double kGainChange = 0.01;

/// How fast R may change with the temperature of the air, as a share of R: 0.77 K in a minute.
constexpr double kAirChange_per_s = 5e-5;

MotorParameters with_share_of_R(MotorParameters motor, double share) {
    motor.resistance_Ohm *= share;
    return motor;
}

} // namespace

double min_cold_residual_Ohm(const MotorParameters &motor, const AmplifierParameters &amplifier) {
    constexpr double kAnyPeriod_s = 1.0; // irrelevant, as the guard is read before its first update
    return motor.resistance_Ohm -
           WindingGuard(motor, amplifier.max_cancelled_Ohm, kAnyPeriod_s).max_cancelled_Ohm();
}

std::array<MotorTemperature, 3> hottest_motors(const std::array<MotorParameters, 3> &motors) {
    std::array<MotorTemperature, 3> hottest;
    for (std::size_t j = 0; j < motors.size(); ++j) {
        const ThermalParameters &thermal = motors[j].thermal;
        const double housing_share =
            thermal.housing_ambient_K_per_W /
            (thermal.housing_ambient_K_per_W + thermal.winding_housing_K_per_W);
        const double rise_K = thermal.max_winding_C - kWarmestAir_C;
        hottest[j] = {thermal.max_winding_C, kWarmestAir_C + housing_share * rise_K};
    }
    return hottest;
}

WindingGuard::WindingGuard(const MotorParameters &motor, double max_cancelled_Ohm, double period_s,
                           double tolerance)
    : min_(with_share_of_R(motor, 1.0 - tolerance)), most_(with_share_of_R(motor, 1.0 + tolerance)),
      amplifier_limit_Ohm_(max_cancelled_Ohm), period_s_(period_s),
      margin_Ohm_(kGainChange * motor.resistance_Ohm),
      coldest_(motor.thermal, kColdestAir_C, period_s), minimum_(coldest_),
      maximum_(motor.thermal, kWarmestAir_C, period_s) {}

void WindingGuard::set_period(double period_s) noexcept {
    period_s_ = period_s;
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
        known ? std::max(std::abs(current_A), std::abs(current_A_)) : most_.peak_current_A;
    current_A_ = current_A;
    cool_through(missed_periods);
    minimum_.update(min_A * min_A * min_resistance_Ohm(min_, minimum_.winding_C()));
    heat_through(missed_periods, max_A);
    maximum_.update(max_A * max_A * max_resistance_Ohm(most_, maximum_.winding_C()));
    if (is_observed_) {
        const double change_Ohm =
            (1.0 + missed_periods) * kAirChange_per_s * period_s_ * most_.resistance_Ohm;
        observed_.min_Ohm -= change_Ohm;
        observed_.max_Ohm += change_Ohm;
    }
}

/// The file's R within its tolerance, in any air.
ResistanceInterval WindingGuard::tolerated() const noexcept {
    const auto in_air = [](const MotorParameters &motor, double air_C) {
        return motor.resistance_Ohm *
               (1.0 + motor.resistance_rise_per_K * (air_C - kReferenceTemperature_C));
    };
    return {in_air(min_, kColdestAir_C), in_air(most_, kWarmestAir_C)};
}

void WindingGuard::narrow(ResistanceInterval observed) noexcept {
    if (is_contradicted_) {
        return;
    }
    const ResistanceInterval before = is_observed_ ? observed_ : tolerated();
    observed.min_Ohm = std::max(observed.min_Ohm - margin_Ohm_, before.min_Ohm);
    observed.max_Ohm = std::min(observed.max_Ohm + margin_Ohm_, before.max_Ohm);
    observed_ = observed;
    is_contradicted_ = observed.is_empty();
    is_observed_ = !is_contradicted_;
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

/// With the maximum possible heat; over a long gap, with that of a winding at its limit.
void WindingGuard::heat_through(std::uint32_t missed_periods, double max_A) noexcept {
    if (missed_periods > kMaxAtOnce) {
        const double hot_C = std::max(maximum_.winding_C(), most_.thermal.max_winding_C);
        WindingTemperature whole = maximum_;
        whole.set_period(missed_periods * period_s_);
        whole.update(max_A * max_A * max_resistance_Ohm(most_, hot_C));
        maximum_.raise_to(whole.temperature());
        return;
    }
    for (std::uint32_t i = 0; i < missed_periods; ++i) {
        maximum_.update(max_A * max_A * max_resistance_Ohm(most_, maximum_.winding_C()));
    }
}

/// R(T, θ), at least.
double WindingGuard::min_Ohm() const noexcept {
    return min_resistance_Ohm(min_, minimum_.winding_C());
}

double WindingGuard::max_cancelled_Ohm() const noexcept {
    return std::clamp((1.0 - kMinResidualShare) * min_Ohm(), 0.0, amplifier_limit_Ohm_);
}

} // namespace springdrive::device
