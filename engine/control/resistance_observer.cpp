#include "engine/control/resistance_observer.h"

#include "device/core/motor/winding_guard.h"

#include <algorithm>
#include <cmath>

namespace springdrive::control {

namespace {

// The states, in this order; cosine and sine of each harmonic follow each other.
constexpr Eigen::Index kResistance = 0;     ///< mean over the angles, at 25 °C [Ω]
constexpr Eigen::Index kRipple = 1;         ///< four amplitudes [Ω]
constexpr Eigen::Index kOffset = 5;         ///< of the current [A]
constexpr Eigen::Index kTorqueConstant = 6; ///< [N·m/A]
constexpr Eigen::Index kRounding = 7;       ///< of the last angle [rad]

/// The second harmonic's amplitude as a share of the first's, as assumed before it is observed.
constexpr double kSecondHarmonic = 0.25;

/// How far the thermal network may go astray [Ω²/s]: a milliohm in a second.
constexpr double kDrift_Ohm2_per_s = 1e-6;

/// Intervals are added up to windows of this [s]. A mean current from those at an interval's ends
/// is wrong by what the speed changes in between, which goes with the current itself; over a window
/// only its ends count.
constexpr double kWindow_s = 0.032;

/// What the speed at a window's ends may cost [V·s].
constexpr double kMeanCurrent_Vs = 3e-6;

/// By which the air may be warmer or colder than its middle, 25 °C [K].
constexpr double kAir_K = 0.5 * (device::kWarmestAir_C - device::kColdestAir_C);

/// Variance of what is uniform within ± `half_width`.
[[nodiscard]] constexpr double uniform_variance(double half_width) {
    return half_width * half_width / 3.0;
}

/// The mean current as a weighted mean of those at the ends, for a constant net voltage: the weight
/// of the first one. z = dR T/L.
[[nodiscard]] double weight_of_first(double z) noexcept {
    if (std::abs(z) < 1e-3) {
        return 0.5 - z / 12.0; // to 1e-12
    }
    return 1.0 / z - 1.0 / std::expm1(z);
}

} // namespace

ResistanceObserver::ResistanceObserver(const device::DeviceDescription &device, std::size_t motor,
                                       double period_s)
    : motor_(device.motor[motor]),
      count_variance_rad2_(uniform_variance(0.5 * device.rad_per_count())),
      current_variance_A2_(device.current_sensing.noise_A * device.current_sensing.noise_A +
                           uniform_variance(0.5 * device.current_sensing.resolution_A)),
      temperature_(motor_.thermal, device::kReferenceTemperature_C, period_s) {
    const double R_Ohm = motor_.resistance_Ohm;
    const device::CurrentSensing &sensing = device.current_sensing;
    state_[kResistance] = R_Ohm;
    state_[kTorqueConstant] = motor_.torque_constant_Nm_per_A;
    covariance_(kResistance, kResistance) =
        R_Ohm * R_Ohm *
        (uniform_variance(motor_.resistance_tolerance) + uniform_variance(sensing.gain_tolerance) +
         uniform_variance(motor_.resistance_rise_per_K * kAir_K));
    const double ripple_Ohm = R_Ohm * motor_.commutation_ripple;
    for (Eigen::Index i = 0; i < 4; ++i) {
        const double amplitude_Ohm = i < 2 ? ripple_Ohm : kSecondHarmonic * ripple_Ohm;
        covariance_(kRipple + i, kRipple + i) = 0.5 * amplitude_Ohm * amplitude_Ohm;
    }
    covariance_(kOffset, kOffset) = uniform_variance(sensing.max_offset_A);
    covariance_(kTorqueConstant, kTorqueConstant) =
        uniform_variance(motor_.torque_constant_tolerance * motor_.torque_constant_Nm_per_A);
    covariance_(kRounding, kRounding) = count_variance_rad2_;
}

/// R(T)/R at 25 °C.
double ResistanceObserver::warmth() const noexcept {
    return 1.0 + motor_.resistance_rise_per_K *
                     (temperature_.winding_C() - device::kReferenceTemperature_C);
}

ResistanceObserver::State
ResistanceObserver::weights_of_resistance(double theta_rad) const noexcept {
    const double phase_rad = motor_.commutator_segments * theta_rad;
    State weights = State::Zero();
    weights[kResistance] = 1.0;
    weights[kRipple] = std::cos(phase_rad);
    weights[kRipple + 1] = std::sin(phase_rad);
    weights[kRipple + 2] = std::cos(2.0 * phase_rad);
    weights[kRipple + 3] = std::sin(2.0 * phase_rad);
    return warmth() * weights;
}

void ResistanceObserver::update(const DrivenInterval &interval) noexcept {
    const double T = interval.duration_s;
    const State of_resistance =
        weights_of_resistance(0.5 * (interval.before_rad + interval.after_rad));
    const double R_Ohm = of_resistance.dot(state_);
    const double dR_Ohm = R_Ohm - interval.R_hat_Ohm;
    const double first = weight_of_first(dR_Ohm * T / motor_.inductance_H);
    const double mean_A = first * interval.before_A + (1.0 - first) * interval.after_A;
    voltage_Vs_ += interval.e_W_V * T + interval.R_hat_Ohm * mean_A * T -
                   motor_.inductance_H * (interval.after_A - interval.before_A);
    weights_ += (mean_A - state_[kOffset]) * T * of_resistance;
    weights_[kOffset] -= R_Ohm * T;
    current_Vs2_ += dR_Ohm * dR_Ohm * T * T * current_variance_A2_;
    turned_rad_ += interval.after_rad - interval.before_rad;
    window_s_ += T;
    temperature_.update(std::max(0.0, R_Ohm) * mean_A * mean_A);
    if (window_s_ >= kWindow_s) {
        take_window();
    }
}

/// The Kalman filter's step.
void ResistanceObserver::take_window() noexcept {
    const double k_T = state_[kTorqueConstant];
    State h = weights_; // derivatives of what was measured
    h[kTorqueConstant] = turned_rad_ + state_[kRounding];
    h[kRounding] = k_T;
    // The current's offset is in the weights of R, and rounding in that of k_T.
    const double expected_Vs =
        h.dot(state_) - h[kOffset] * state_[kOffset] - k_T * state_[kRounding];
    covariance_(kResistance, kResistance) += kDrift_Ohm2_per_s * window_s_;

    // Of the new angle's rounding, and of the currents at the ends.
    const double rounding_Vs2 = k_T * k_T * count_variance_rad2_;
    const double ends_Vs2 = 2.0 * motor_.inductance_H * motor_.inductance_H * current_variance_A2_ +
                            kMeanCurrent_Vs * kMeanCurrent_Vs;
    const State gain_numerator = covariance_ * h;
    const double variance_Vs2 = h.dot(gain_numerator) + rounding_Vs2 + ends_Vs2 + current_Vs2_;
    const State gain = gain_numerator / variance_Vs2;
    const double surprise_Vs = voltage_Vs_ - expected_Vs;
    state_ += surprise_Vs * gain;
    covariance_ -= gain * gain_numerator.transpose();

    // The new angle's rounding takes the old one's place. It entered with the factor −k_T.
    const double rounding_gain = -k_T * count_variance_rad2_ / variance_Vs2;
    state_[kRounding] = rounding_gain * surprise_Vs;
    covariance_.row(kRounding) = -rounding_gain * gain_numerator.transpose();
    covariance_.col(kRounding) = covariance_.row(kRounding).transpose();
    covariance_(kRounding, kRounding) =
        count_variance_rad2_ - rounding_gain * rounding_gain * variance_Vs2;

    voltage_Vs_ = current_Vs2_ = turned_rad_ = window_s_ = 0.0;
    weights_.setZero();
}

ResistanceEstimate ResistanceObserver::estimate(const State &weights) const noexcept {
    return {weights.dot(state_), std::sqrt(std::max(0.0, weights.dot(covariance_ * weights)))};
}

ResistanceEstimate ResistanceObserver::at(double theta_rad) const noexcept {
    return estimate(weights_of_resistance(theta_rad));
}

ResistanceEstimate ResistanceObserver::mean() const noexcept {
    State weights = State::Zero();
    weights[kResistance] = warmth();
    return estimate(weights);
}

} // namespace springdrive::control
