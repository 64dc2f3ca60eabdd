#include "engine/control/winding_observer.h"

#include "device/core/motor/winding_heat.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace springdrive::control {

namespace {

// The states, in this order; cosine and sine of each harmonic follow each other.
constexpr Eigen::Index kResistance = 0; ///< mean over the angles, at 25 °C [Ω]
constexpr Eigen::Index kRipple = 1;     ///< four amplitudes [Ω]
constexpr Eigen::Index kRippleEnd = 5;
constexpr Eigen::Index kOffset = 5;         ///< of the current [A]
constexpr Eigen::Index kTorqueConstant = 6; ///< [N·m/A]
constexpr Eigen::Index kRounding = 7;       ///< of the last angle [rad]

/// By how much the file's R may be wrong, whatever tolerance it states: it may be another motor's.
/// Only a file without any tolerance is of a device that is exactly known.
constexpr double kFileError = 0.2;

/// How far the sensor's offset may drift [A²/s]: 0.01 mA in a second.
constexpr double kOffsetDrift_A2_per_s = 1e-10;

/// An estimate is settled once its standard deviation has been below this share of R for so long.
constexpr double kSettled = 0.02;
constexpr double kSettling_s = 0.5;

/// A window that surprises by more than this many standard deviations teaches nothing.
constexpr double kOutlier = 4.0;

/// So many outliers, less a quarter of the other windows, and nothing is believed.
constexpr double kMaxDisbelief = 8.0;
constexpr double kBelief = 0.25;

/// The second harmonic's amplitude as a share of the first's, as assumed before it is observed: the
/// r.m.s. of what lies between none and a rectified sine's 0.2.
constexpr double kSecondHarmonic = 0.12;

/// How far R may drift while its temperature is constant [Ω²/s]: 0.03 mΩ in a second.
constexpr double kDrift_Ohm2_per_s = 1e-9;

/// By which share the thermal network may be wrong about a change of R, when R has changed by
/// kWarmthChange: air 10 K warmer or colder makes 4 %.
constexpr double kNetworkError = 0.05;
constexpr double kWarmthChange = 0.1;

/// Intervals are added up to windows of this [s]. A mean current from those at an interval's ends
/// is wrong by what the speed changes in between, which goes with the current itself; over a window
/// only its ends count.
constexpr double kWindow_s = 0.032;

/// What the speed at a window's ends may cost [V·s], and of what an acceleration costs, the share
/// that is left.
constexpr double kMeanCurrent_Vs = 1e-6;
constexpr double kAcceleration = 0.2;

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

/// What a step of the net voltage adds to that mean [A], after a share `at` of the interval.
/// @param step_A  that the step would change the current by in the interval without a resistance
[[nodiscard]] double mean_of_step_A(double z, double step_A, double at) noexcept {
    const double rest = 1.0 - at;
    if (std::abs(z) < 1e-3) {
        return -0.5 * step_A * at * rest;
    }
    const double reached = -std::expm1(-z * rest); // of the step's final current
    return step_A / z * (rest - reached / z - (1.0 - weight_of_first(z)) * reached);
}

/// How far the current has come from the first to the last one after a share x of the interval, for
/// a constant net voltage, as a share.
[[nodiscard]] double way_after(double z, double x) noexcept {
    if (std::abs(z) < 1e-3) {
        return x + 0.5 * z * x * (1.0 - x); // to 1e-6
    }
    return std::expm1(-z * x) / std::expm1(-z);
}

/// The mean square of a current between two, for a constant net voltage: what warms.
[[nodiscard]] double mean_square_A2(double z, double from_A, double to_A) noexcept {
    const double q = -std::expm1(-z);
    const double way = 1.0 - weight_of_first(z); // its mean, and that of its square
    const double way2 = std::abs(z) < 1e-3 ? 1.0 / 3.0 + z / 12.0 // to 1e-6
                                           : (1.0 - q / z * (1.0 + 0.5 * q)) / (q * q);
    const double change_A = to_A - from_A;
    return from_A * from_A + 2.0 * from_A * change_A * way + change_A * change_A * way2;
}

/// The same with a step of the net voltage. Where the voltage changes its sign with every tick, the
/// mean current is none, and there is heat.
[[nodiscard]] double mean_square_A2(double z, const DrivenInterval &interval,
                                    double step_A) noexcept {
    const double at = interval.step_at;
    const double rest = 1.0 - at;
    const double by_step_A =
        step_A * (std::abs(z) < 1e-3 ? rest * (1.0 - 0.5 * z * rest) : -std::expm1(-z * rest) / z);
    const double at_step_A =
        interval.before_A + (interval.after_A - interval.before_A - by_step_A) * way_after(z, at);
    return at * mean_square_A2(z * at, interval.before_A, at_step_A) +
           rest * mean_square_A2(z * rest, at_step_A, interval.after_A);
}

} // namespace

double mean_current_A(const DrivenInterval &interval, double dR_Ohm, double inductance_H) noexcept {
    const double z = dR_Ohm * interval.duration_s / inductance_H;
    const double first = weight_of_first(z);
    const double step_A = interval.e_W_step_V * interval.duration_s / inductance_H;
    return first * interval.before_A + (1.0 - first) * interval.after_A +
           mean_of_step_A(z, step_A, interval.step_at);
}

ObservedMotor known_at_start(const device::DeviceDescription &device, std::size_t motor) {
    constexpr double kAny_s = 1e-3;
    return WindingObserver(device, motor, kAny_s).motor(0.0);
}

double touch_left_s(const device::DeviceDescription &device, std::size_t motor,
                    const ObservedMotor &known, double dR_Ohm, double current_A) {
    if (!known.is_trusted) {
        return 0.0;
    }
    const double deviation_Ohm = held_up_dR_Ohm(known) / kHeldUpDeviations;
    const double enough_Ohm =
        device::residual_resistance_Ohm(device.motor[motor], dR_Ohm) / kHeldUpDeviations;
    if (deviation_Ohm <= enough_Ohm) {
        return 0.0;
    }
    const double count_V = device.motor[motor].torque_constant_Nm_per_A * device.rad_per_count() /
                           std::sqrt(6.0) / kWindow_s; // rounded at both ends
    const double window_Ohm = count_V / std::abs(current_A);
    return kWindow_s * window_Ohm * window_Ohm *
           (1.0 / (enough_Ohm * enough_Ohm) - 1.0 / (deviation_Ohm * deviation_Ohm));
}

WindingObserver::WindingObserver(const device::DeviceDescription &device, std::size_t motor,
                                 double period_s)
    : motor_(device.motor[motor]), sensing_(device.current_sensing),
      count_variance_rad2_(uniform_variance(0.5 * device.rad_per_count())),
      current_variance_A2_(sensing_.noise_A * sensing_.noise_A +
                           uniform_variance(0.5 * sensing_.resolution_A)),
      zero_by_eye_rad_(device.geometry.transmission_ratio[static_cast<Eigen::Index>(motor)] *
                       std::sqrt(uniform_variance(device::kZeroByEye_rad))),
      temperature_(motor_.thermal, device::kReferenceTemperature_C, period_s) {
    if (const std::optional<device::Calibration> &calibration = device.calibration) {
        calibration_ = calibration->motor[motor];
        air_variance_K2_ = uniform_variance(calibration->air_error_K) + uniform_variance(kAir_K);
        has_zero_of_calibration_ = calibration->has_lasting_zero();
    }
    restart();
}

void WindingObserver::restart() noexcept {
    start_from_file();
    if (calibration_) {
        start_from_calibration();
    }
    begin_window();
    mean_before_A_ = 0.0;
    settled_windows_ = 0;
    disbelief_ = 0.0;
    is_trusted_ = true;
}

void WindingObserver::start_from_file() noexcept {
    const double R_Ohm = motor_.resistance_Ohm;
    const double file_error =
        motor_.resistance_tolerance > 0.0 ? std::max(motor_.resistance_tolerance, kFileError) : 0.0;
    state_.setZero();
    state_[kResistance] = R_Ohm;
    state_[kTorqueConstant] = motor_.torque_constant_Nm_per_A;
    covariance_.setZero();
    covariance_(kResistance, kResistance) =
        R_Ohm * R_Ohm *
        (uniform_variance(file_error) + uniform_variance(sensing_.gain_tolerance) +
         uniform_variance(motor_.resistance_rise_per_K * kAir_K));
    const double ripple_Ohm = R_Ohm * motor_.commutation_ripple;
    for (Eigen::Index i = 0; i < 4; ++i) {
        const double amplitude_Ohm = i < 2 ? ripple_Ohm : kSecondHarmonic * ripple_Ohm;
        covariance_(kRipple + i, kRipple + i) = 0.5 * amplitude_Ohm * amplitude_Ohm;
    }
    covariance_(kOffset, kOffset) = uniform_variance(sensing_.max_offset_A);
    covariance_(kTorqueConstant, kTorqueConstant) =
        uniform_variance(motor_.torque_constant_tolerance * motor_.torque_constant_Nm_per_A);
    covariance_(kRounding, kRounding) = count_variance_rad2_;
}

void WindingObserver::start_from_calibration() noexcept {
    const auto square = [](double value) { return value * value; };
    state_[kResistance] = calibration_->resistance_Ohm;
    covariance_(kResistance, kResistance) =
        square(calibration_->resistance_deviation_Ohm) +
        square(calibration_->resistance_Ohm * motor_.resistance_rise_per_K) * air_variance_K2_;
    take_ripple(1, calibration_->ripple_cos_Ohm, calibration_->ripple_sin_Ohm,
                calibration_->ripple_deviation_Ohm);
    take_ripple(2, calibration_->ripple_cos_2_Ohm, calibration_->ripple_sin_2_Ohm,
                calibration_->ripple_2_deviation_Ohm);
    state_[kTorqueConstant] = calibration_->torque_constant_Nm_per_A;
    covariance_(kTorqueConstant, kTorqueConstant) =
        square(calibration_->torque_constant_deviation_Nm_per_A);
    if (has_zero_of_calibration_) {
        state_[kOffset] = calibration_->offset_A;
        covariance_(kOffset, kOffset) = square(calibration_->offset_deviation_A);
    }
}

void WindingObserver::take_ripple(Eigen::Index harmonic, double cos_Ohm, double sin_Ohm,
                                  double deviation_Ohm) noexcept {
    const double phase_rad = static_cast<double>(harmonic) * motor_.commutator_segments *
                             (has_zero_of_calibration_ ? 0.0 : zero_by_eye_rad_);
    const double f = std::exp(-0.5 * phase_rad * phase_rad); // E[cos]
    const double cos2 = 0.5 * (1.0 + f * f * f * f);         // E[cos²]
    const double sin2 = 1.0 - cos2;
    const double a2 = cos_Ohm * cos_Ohm;
    const double b2 = sin_Ohm * sin_Ohm;
    const Eigen::Index i = kRipple + 2 * (harmonic - 1);
    state_[i] = f * cos_Ohm;
    state_[i + 1] = f * sin_Ohm;
    const double variance_Ohm2 = deviation_Ohm * deviation_Ohm;
    covariance_(i, i) = variance_Ohm2 + cos2 * a2 + sin2 * b2 - f * f * a2;
    covariance_(i + 1, i + 1) = variance_Ohm2 + cos2 * b2 + sin2 * a2 - f * f * b2;
    covariance_(i, i + 1) = (cos2 - sin2 - f * f) * cos_Ohm * sin_Ohm;
    covariance_(i + 1, i) = covariance_(i, i + 1);
}

/// R(T)/R at 25 °C.
double WindingObserver::warmth() const noexcept {
    return 1.0 + motor_.resistance_rise_per_K *
                     (temperature_.winding_C() - device::kReferenceTemperature_C);
}

WindingObserver::State WindingObserver::weights_of_resistance(double theta_rad) const noexcept {
    const double phase_rad = motor_.commutator_segments * theta_rad;
    State weights = State::Zero();
    weights[kResistance] = 1.0;
    weights[kRipple] = std::cos(phase_rad);
    weights[kRipple + 1] = std::sin(phase_rad);
    weights[kRipple + 2] = std::cos(2.0 * phase_rad);
    weights[kRipple + 3] = std::sin(2.0 * phase_rad);
    return warmth() * weights;
}

void WindingObserver::skip(double current_A, std::uint32_t periods) noexcept {
    constexpr std::uint32_t kMaxAtOnce = 100;
    const double heat_W = std::isfinite(current_A) ? std::max(0.0, warmth() * state_[kResistance]) *
                                                         current_A * current_A
                                                   : 0.0;
    for (std::uint32_t i = 0; i < std::min(periods, kMaxAtOnce); ++i) {
        temperature_.update(heat_W);
    }
    begin_window();
    mean_before_A_ = 0.0;
    forget_rounding();
}

void WindingObserver::update(const DrivenInterval &interval) noexcept {
    const double T = interval.duration_s;
    period_s_ = T;
    const State of_resistance =
        weights_of_resistance(0.5 * (interval.before_rad + interval.after_rad));
    const double R_Ohm = of_resistance.dot(state_);
    const double dR_Ohm = R_Ohm - interval.R_hat_Ohm;
    const double z = dR_Ohm * T / motor_.inductance_H;
    const double step_A = interval.e_W_step_V * T / motor_.inductance_H;
    const double mean_A = mean_current_A(interval, dR_Ohm, motor_.inductance_H);
    voltage_Vs_ += interval.e_W_V * T + interval.R_hat_Ohm * mean_A * T -
                   motor_.inductance_H * (interval.after_A - interval.before_A);
    weights_ += (mean_A - state_[kOffset]) * T * of_resistance;
    weights_[kOffset] -= R_Ohm * T;
    const double charge_As2 = T * T * current_variance_A2_;
    charge_As2_ += charge_As2;
    bias_VAs2_ += dR_Ohm * charge_As2;
    current_Vs2_ += dR_Ohm * dR_Ohm * charge_As2;
    of_noise_ += T * of_resistance;
    const double rate_rad_per_s = (interval.after_rad - interval.before_rad) / T;
    first_rate_rad_per_s_ = window_s_ > 0.0 ? first_rate_rad_per_s_ : rate_rad_per_s;
    last_rate_rad_per_s_ = rate_rad_per_s;
    asymmetry_s_ += (0.5 - weight_of_first(z)) * T;
    turned_rad_ += interval.after_rad - interval.before_rad;
    window_s_ += T;
    temperature_.update(std::max(0.0, R_Ohm) * mean_square_A2(z, interval, step_A));
    if (window_s_ >= kWindow_s) {
        take_window();
    }
}

/// Ends the present window.
void WindingObserver::take_window() noexcept {
    const double k_T = state_[kTorqueConstant];
    State h = weights_; // derivatives of what was measured
    h[kTorqueConstant] = turned_rad_ + state_[kRounding];
    h[kRounding] = k_T;
    // The current's offset is in the weights of R, and rounding in that of k_T.
    const double expected_Vs =
        h.dot(state_) - h[kOffset] * state_[kOffset] - k_T * state_[kRounding];
    const double warmed = std::abs(warmth() - std::exchange(warmth_before_, warmth()));
    const double network_Ohm = kNetworkError * motor_.resistance_Ohm;
    covariance_(kResistance, kResistance) +=
        kDrift_Ohm2_per_s * window_s_ + network_Ohm * network_Ohm * kWarmthChange * warmed;
    covariance_(kOffset, kOffset) += kOffsetDrift_A2_per_s * window_s_;
    const bool has_evidence = had_current();
    mean_before_A_ = weights_[kResistance] / (warmth() * window_s_);
    // Within an interval the speed changes, and the back-EMF's part of the current with it: of a
    // constant acceleration, dR times what the mean current differs by is this. It goes with the
    // current, so that it would be taken for R. Its rates are known to a count in an interval.
    const double lag_Vs2_per_rad = k_T * asymmetry_s_ / window_s_ * period_s_;
    const double accelerated_Vs = lag_Vs2_per_rad * (last_rate_rad_per_s_ - first_rate_rad_per_s_);
    const double rates_Vs = 2.0 * lag_Vs2_per_rad * std::sqrt(count_variance_rad2_) / period_s_;
    const double left_Vs = kAcceleration * accelerated_Vs;
    const double ends_Vs2 = 2.0 * motor_.inductance_H * motor_.inductance_H * current_variance_A2_ +
                            kMeanCurrent_Vs * kMeanCurrent_Vs + rates_Vs * rates_Vs +
                            left_Vs * left_Vs;
    const double surprise_Vs = voltage_Vs_ - expected_Vs - accelerated_Vs;
    // A product of two unknowns, R and the offset, which h leaves out.
    const State of_current = of_noise_ / window_s_;
    const State spread = covariance_ * of_current;
    const double product_Vs2 = window_s_ * window_s_ *
                               (of_current.dot(spread) * covariance_(kOffset, kOffset) +
                                spread[kOffset] * spread[kOffset]);
    const Noise noise{ends_Vs2 + current_Vs2_ + product_Vs2, charge_As2_, bias_VAs2_, of_current};
    begin_window();
    if (is_trusted_) {
        learn(h, surprise_Vs, noise, has_evidence);
    }
}

/// Whether the mean current is far above noise and what is not known of its offset. If it is not, a
/// product of two unknowns is no evidence about R: a linearised filter would take it for some. That
/// of the window before decides, or windows would be chosen by their own noise.
bool WindingObserver::had_current() const noexcept {
    constexpr double kDeviations = 10.0;
    const double variance_A2 =
        current_variance_A2_ * period_s_ / kWindow_s + covariance_(kOffset, kOffset);
    return mean_before_A_ * mean_before_A_ > kDeviations * kDeviations * variance_A2;
}

void WindingObserver::begin_window() noexcept {
    voltage_Vs_ = current_Vs2_ = charge_As2_ = bias_VAs2_ = asymmetry_s_ = turned_rad_ = window_s_ =
        0.0;
    weights_.setZero();
    of_noise_.setZero();
}

/// The Kalman filter's step.
/// @param h             derivatives of what was measured
/// @param has_evidence  of R; if not, R stays as it is, and what is not known of it is considered
///                      in what is learned of the others (Schmidt)
void WindingObserver::learn(const State &h, double surprise_Vs, const Noise &noise,
                            bool has_evidence) noexcept {
    const double k_T = h[kRounding];
    const State gain_numerator = covariance_ * h;
    const double rounding_Vs2 = k_T * k_T * count_variance_rad2_;
    const double variance_Vs2 = h.dot(gain_numerator) + rounding_Vs2 + noise.voltage_Vs2;
    const bool is_outlier = !(surprise_Vs * surprise_Vs < kOutlier * kOutlier * variance_Vs2);
    note_surprise(is_outlier);
    if (is_outlier) {
        forget_rounding();
        return;
    }
    State gain = gain_numerator / variance_Vs2;
    if (!has_evidence) {
        gain.segment<kRippleEnd - kResistance>(kResistance).setZero();
    }
    state_ += surprise_Vs * gain;
    const Covariance taken = gain * gain_numerator.transpose();
    covariance_ += variance_Vs2 * gain * gain.transpose() - taken - taken.transpose();

    // The new angle's rounding takes the old one's place. It entered with the factor −k_T.
    const double rounding_gain = -k_T * count_variance_rad2_ / variance_Vs2;
    state_[kRounding] = rounding_gain * surprise_Vs;
    covariance_.row(kRounding) = -rounding_gain * gain_numerator.transpose();
    covariance_.col(kRounding) = covariance_.row(kRounding).transpose();
    covariance_(kRounding, kRounding) =
        count_variance_rad2_ - rounding_gain * rounding_gain * variance_Vs2;
    if (has_evidence) {
        compensate(noise, rounding_Vs2 + noise.voltage_Vs2);
        const ResistanceEstimate R = unheated();
        settled_windows_ += R.deviation_Ohm < kSettled * R.resistance_Ohm ? 1 : 0;
    }
}

/// The current's noise is in h as well: it looks like a current that changes, whose voltage changes
/// by R̂ times it, and so, in time, like an R of R̂. What that adds to the information about R,
/// and to R, is taken off again.
void WindingObserver::compensate(const Noise &noise, double variance_Vs2) noexcept {
    const State spread = covariance_ * noise.of_current;
    const double information = noise.charge_As2 / variance_Vs2;
    const double left = 1.0 - information * noise.of_current.dot(spread);
    if (left > 0.5) {
        covariance_ += (information / left) * spread * spread.transpose();
        state_ += (noise.bias_VAs2 / (variance_Vs2 * left)) * spread;
    }
}

/// The last angle is another, whose rounding is not known.
void WindingObserver::forget_rounding() noexcept {
    state_[kRounding] = 0.0;
    covariance_.row(kRounding).setZero();
    covariance_.col(kRounding).setZero();
    covariance_(kRounding, kRounding) = count_variance_rad2_;
}

void WindingObserver::note_surprise(bool is_outlier) noexcept {
    disbelief_ = std::max(0.0, disbelief_ + (is_outlier ? 1.0 : -kBelief));
    settled_windows_ = disbelief_ > 0.0 ? 0 : settled_windows_;
    if (disbelief_ >= kMaxDisbelief) {
        distrust();
    }
}

bool WindingObserver::is_settled() const noexcept {
    return settled_windows_ * kWindow_s >= kSettling_s;
}

void WindingObserver::distrust() noexcept {
    restart();
    start_from_file(); // it may be the calibration that is wrong
    is_trusted_ = false;
}

ResistanceEstimate WindingObserver::estimate(const State &weights) const noexcept {
    return {weights.dot(state_), std::sqrt(std::max(0.0, weights.dot(covariance_ * weights)))};
}

device::MotorCalibration WindingObserver::learned() const noexcept {
    const auto deviation = [this](Eigen::Index state) {
        return std::sqrt(std::max(0.0, covariance_(state, state)));
    };
    device::MotorCalibration learned;
    learned.resistance_Ohm = state_[kResistance];
    learned.resistance_deviation_Ohm = deviation(kResistance);
    learned.ripple_cos_Ohm = state_[kRipple];
    learned.ripple_sin_Ohm = state_[kRipple + 1];
    learned.ripple_deviation_Ohm = std::max(deviation(kRipple), deviation(kRipple + 1));
    learned.ripple_cos_2_Ohm = state_[kRipple + 2];
    learned.ripple_sin_2_Ohm = state_[kRipple + 3];
    learned.ripple_2_deviation_Ohm = std::max(deviation(kRipple + 2), deviation(kRipple + 3));
    learned.torque_constant_Nm_per_A = state_[kTorqueConstant];
    learned.torque_constant_deviation_Nm_per_A = deviation(kTorqueConstant);
    learned.offset_A = state_[kOffset];
    learned.offset_deviation_A = deviation(kOffset);
    return learned;
}

ObservedMotor WindingObserver::motor(double theta_rad) const noexcept {
    const double k_T = motor_.torque_constant_Nm_per_A;
    const double k_T_tolerance = motor_.torque_constant_tolerance * k_T;
    return {at(theta_rad),
            mean(),
            std::clamp(state_[kTorqueConstant], k_T - k_T_tolerance, k_T + k_T_tolerance),
            std::clamp(state_[kOffset], -sensing_.max_offset_A, sensing_.max_offset_A),
            true,
            is_trusted_};
}

ResistanceEstimate WindingObserver::at(double theta_rad) const noexcept {
    return estimate(weights_of_resistance(theta_rad));
}

ResistanceEstimate WindingObserver::mean() const noexcept {
    State weights = State::Zero();
    weights[kResistance] = warmth();
    return estimate(weights);
}

ResistanceEstimate WindingObserver::unheated() const noexcept {
    State weights = State::Zero();
    weights[kResistance] = 1.0;
    return estimate(weights);
}

} // namespace springdrive::control
