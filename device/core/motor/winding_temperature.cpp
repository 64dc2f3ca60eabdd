#include "device/core/motor/winding_temperature.h"

#include <Eigen/Core>

#include <cmath>

namespace springdrive::device {

namespace {

/// R(T), averaged over the commutator's angles.
double mean_resistance_Ohm(const MotorParameters &motor, double winding_C) {
    return motor.resistance_Ohm *
           (1.0 + motor.resistance_rise_per_K * (winding_C - kReferenceTemperature_C));
}

} // namespace

double winding_resistance_Ohm(const MotorParameters &motor, double winding_C, double theta_rad) {
    const double mean_Ohm = mean_resistance_Ohm(motor, winding_C);
    if (motor.commutation_ripple == 0.0) {
        return mean_Ohm;
    }
    const double phase_rad = motor.commutator_segments * theta_rad + motor.commutator_phase_rad;
    return mean_Ohm * (1.0 + motor.commutation_ripple * std::cos(phase_rad));
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

} // namespace springdrive::device
