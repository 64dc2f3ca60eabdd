#include "device/core/motor/winding_heat.h"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace springdrive::device {

namespace {

/// R(T), averaged over the commutator's angles.
double mean_resistance_Ohm(const MotorParameters &motor, double winding_C) {
    return motor.resistance_Ohm *
           (1.0 + motor.resistance_rise_per_K * (winding_C - kReferenceTemperature_C));
}

/// What a sensor's gain may change after an observation, as a share of R.
constexpr double kGainChange = 0.01;

/// How fast R may change with the temperature of the air, as a share of R: 0.77 K in a minute.
constexpr double kAirChange_per_s = 5e-5;

MotorParameters with_share_of_R(MotorParameters motor, double share) {
    motor.resistance_Ohm *= share;
    return motor;
}

/// A motor that leads its winding's heat away as well as any of its kind: with the same copper,
/// R_wh and with it t_w may be half of the data sheet's. More heat in the winding and less in the
/// housing leaves the winding warmer from then on, so that no larger R_wh makes it colder.
ThermalParameters leading_well(ThermalParameters thermal) {
    thermal.winding_housing_K_per_W /= kMaxHeatPathFactor;
    thermal.winding_time_s /= kMaxHeatPathFactor;
    return thermal;
}

} // namespace

double winding_resistance_Ohm(const MotorParameters &motor, double winding_C, double theta_rad) {
    const double mean_Ohm = mean_resistance_Ohm(motor, winding_C);
    if (motor.commutation_ripple == 0.0) {
        return mean_Ohm;
    }
    const double turned_rad = motor.commutator_segments * theta_rad;
    double ripple = motor.commutation_ripple * std::cos(turned_rad + motor.commutator_phase_rad);
    if (motor.second_harmonic != 0.0) {
        ripple +=
            motor.second_harmonic * std::cos(2.0 * turned_rad + motor.second_harmonic_phase_rad);
    }
    return mean_Ohm * (1.0 + ripple);
}

double min_resistance_Ohm(const MotorParameters &motor, double winding_C) {
    return mean_resistance_Ohm(motor, winding_C) * (1.0 - motor.commutation_ripple);
}

double max_resistance_Ohm(const MotorParameters &motor, double winding_C) {
    return mean_resistance_Ohm(motor, winding_C) * (1.0 + motor.commutation_ripple);
}

WindingTemperature::WindingTemperature(const ThermalParameters &thermal, double ambient_C,
                                       double period_s)
    : thermal_(thermal), ambient_C_(ambient_C), winding_C_(ambient_C), housing_C_(ambient_C) {
    set_period(period_s);
}

void WindingTemperature::set_period(double period_s) noexcept {
    const double winding_J_per_K = thermal_.winding_time_s / thermal_.winding_housing_K_per_W;
    const double housing_J_per_K = thermal_.motor_time_s / thermal_.housing_ambient_K_per_W;
    const double inward = 1.0 / thermal_.winding_housing_K_per_W;
    const double outward = 1.0 / thermal_.housing_ambient_K_per_W;
    Eigen::Matrix2d rates;
    rates << -inward / winding_J_per_K, inward / winding_J_per_K, //
        inward / housing_J_per_K, -(inward + outward) / housing_J_per_K;

    // The exponential of a matrix with two distinct real eigenvalues, minus the identity.
    const double middle = 0.5 * rates.trace();
    const double apart =
        std::sqrt(0.25 * std::pow(rates(0, 0) - rates(1, 1), 2) + rates(0, 1) * rates(1, 0));
    const Eigen::Matrix2d identity = Eigen::Matrix2d::Identity();
    const Eigen::Matrix2d change =
        (std::expm1((middle + apart) * period_s) * (rates - (middle - apart) * identity) -
         std::expm1((middle - apart) * period_s) * (rates - (middle + apart) * identity)) /
        (2.0 * apart);
    winding_from_winding_ = 1.0 + change(0, 0);
    winding_from_housing_ = change(0, 1);
    housing_from_winding_ = change(1, 0);
    housing_from_housing_ = 1.0 + change(1, 1);

    // The steady state for one watt, and the part of it reached within the period.
    const Eigen::Vector2d steady_K(thermal_.winding_housing_K_per_W +
                                       thermal_.housing_ambient_K_per_W,
                                   thermal_.housing_ambient_K_per_W);
    const Eigen::Vector2d gained_K = -change * steady_K;
    winding_K_per_W_ = gained_K[0];
    housing_K_per_W_ = gained_K[1];
}

void WindingTemperature::update(double heat_W) noexcept {
    const double winding_K = winding_C_ - ambient_C_;
    const double housing_K = housing_C_ - ambient_C_;
    winding_C_ = ambient_C_ + winding_from_winding_ * winding_K +
                 winding_from_housing_ * housing_K + winding_K_per_W_ * heat_W;
    housing_C_ = ambient_C_ + housing_from_winding_ * winding_K +
                 housing_from_housing_ * housing_K + housing_K_per_W_ * heat_W;
}

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
      coldest_(leading_well(motor.thermal), kColdestAir_C, period_s), minimum_(coldest_),
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
