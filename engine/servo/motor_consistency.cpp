#include "engine/servo/motor_consistency.h"

#include "device/core/motor/winding_heat.h"

#include <algorithm>
#include <cmath>

namespace springdrive::servo {

namespace {

/// k_T is at least so uncertain, as a share of it, whatever the file says.
constexpr double kTorqueConstant = 0.15;

/// By which share of itself an amplifier's e_W may be wrong.
constexpr double kAmplifier = 0.02;

/// A rotation of the rotor is unexplained beyond this, and beyond what a delay that is wrong by
/// kDelay_periods makes of the largest step of e_W.
constexpr double kUnexplained_rad = 0.1;

/// Beyond this share of supply and peak current an amplifier may do something else.
constexpr double kWithinLimits = 0.9;

/// Levels are known of currents above this [A], where V_b is saturated, and which are steady to a
/// share of themselves for so long.
constexpr double kLevel_A = 0.3;
constexpr double kSteady = 0.2;
constexpr double kWindow_s = 0.016;

/// What an interval may be wrong by [V], of noise and rounding.
constexpr double kNoise_V = 0.02;

/// How fast a winding cools at the most [K/s].
constexpr double kCooling_K_per_s = 7.0;

/// The ripple's slope and amplitude, of all harmonics, against those of the first.
constexpr double kRippleSlope = 2.0;
constexpr double kRippleAmplitude = 1.5;

} // namespace

MotorConsistency::MotorConsistency(const device::DeviceDescription &device, std::size_t motor,
                                   double period_s)
    : motor_(device.motor[motor]), sensing_(device.current_sensing),
      tolerance_(device.resistance_tolerance(motor)),
      k_T_tolerance_(std::max(kTorqueConstant, motor_.torque_constant_tolerance)),
      ripple_Ohm_(kRippleAmplitude * motor_.commutation_ripple * motor_.resistance_Ohm) {
    set_period(period_s);
}

void MotorConsistency::set_period(double period_s) noexcept {
    limit_rad_ = kUnexplained_rad +
                 kDelay_periods * period_s * motor_.supply_V / motor_.torque_constant_Nm_per_A;
}

void MotorConsistency::reset() noexcept {
    above_Vs_ = below_Vs_ = 0.0;
    window_ = {};
    level_.reset();
}

double MotorConsistency::unexplained_rad() const noexcept {
    return std::max(above_Vs_, below_Vs_) / motor_.torque_constant_Nm_per_A;
}

/// R i + V_b, from the smallest to the largest.
Bounds MotorConsistency::drop_V(double current_A, const Bounds &R_Ohm) const noexcept {
    const double off_A = sensing_.max_offset_A + sensing_.noise_A;
    const double min_A = current_A - off_A;
    const double max_A = current_A + off_A;
    Bounds drop_V{min_A * (min_A > 0.0 ? R_Ohm.min : R_Ohm.max),
                  max_A * (max_A > 0.0 ? R_Ohm.max : R_Ohm.min)};
    drop_V.min -= min_A > 0.0 ? 0.0 : motor_.max_brush_voltage_V;
    drop_V.max += max_A < 0.0 ? 0.0 : motor_.max_brush_voltage_V;
    return drop_V;
}

/// R + V_b/i at another current than the level's.
Bounds MotorConsistency::at_current(double current_A, const Bounds &known_Ohm) const noexcept {
    const double less_per_A = 1.0 / std::abs(current_A) - 1.0 / std::abs(level_->current_A);
    const double offset_Ohm =
        (sensing_.max_offset_A * motor_.resistance_Ohm + kNoise_V) * std::abs(less_per_A);
    const double brush_Ohm = motor_.max_brush_voltage_V * less_per_A;
    return known_Ohm.wider(offset_Ohm - std::min(0.0, brush_Ohm),
                           offset_Ohm + std::max(0.0, brush_Ohm));
}

/// The same, by all that is known of it.
Bounds MotorConsistency::apparent_Ohm(double current_A) const noexcept {
    return at_current(current_A,
                      level_->here_Ohm.and_also(level_->mean_Ohm.wider(ripple_Ohm_, ripple_Ohm_)));
}

void MotorConsistency::update(const control::DrivenInterval &interval, double min_C,
                              double max_C) noexcept {
    const Bounds R_Ohm{(1.0 - tolerance_) * device::min_resistance_Ohm(motor_, min_C),
                       (1.0 + tolerance_) * device::max_resistance_Ohm(motor_, max_C)};
    const double T = interval.duration_s;
    const double dR_Ohm = 0.5 * (R_Ohm.min + R_Ohm.max) - interval.R_hat_Ohm;
    const double mean_A = control::mean_current_A(interval, dR_Ohm, motor_.inductance_H);
    const double across_V = interval.e_W_V + interval.R_hat_Ohm * mean_A;
    const double largest_A = std::max(std::abs(interval.before_A), std::abs(interval.after_A));
    if (!(std::abs(interval.e_W_V) + interval.R_hat_Ohm * largest_A <
          kWithinLimits * motor_.supply_V) ||
        !(largest_A < kWithinLimits * motor_.peak_current_A)) {
        window_ = {};
        return;
    }
    const double voltage_Vs =
        across_V * T - motor_.inductance_H * (interval.after_A - interval.before_A);
    Bounds drop = drop_V(mean_A, R_Ohm); // [V]
    if (level_ && mean_A * level_->current_A > 0.0 && std::abs(mean_A) > kLevel_A) {
        const Bounds known_Ohm = apparent_Ohm(mean_A);
        const double from_V = mean_A * known_Ohm.min;
        const double to_V = mean_A * known_Ohm.max;
        drop.min = std::max(drop.min, std::min(from_V, to_V));
        drop.max = std::min(drop.max, std::max(from_V, to_V));
    }
    double amplifier_V = kAmplifier * std::abs(interval.e_W_V);
    if (!sensing_.is_shared) { // R̂ times another sensor's reading
        amplifier_V += 2.0 * interval.R_hat_Ohm *
                       (sensing_.gain_tolerance * largest_A + sensing_.max_offset_A);
    }
    const double turned_rad = interval.after_rad - interval.before_rad;
    const double turned_Vs = motor_.torque_constant_Nm_per_A * turned_rad;
    const double within_Vs = k_T_tolerance_ * std::abs(turned_Vs) + amplifier_V * T;
    above_Vs_ = std::max(0.0, above_Vs_ + turned_Vs - within_Vs - (voltage_Vs - drop.min * T));
    below_Vs_ = std::max(0.0, below_Vs_ - turned_Vs - within_Vs + (voltage_Vs - drop.max * T));
    learn(interval, voltage_Vs, mean_A);
}

void MotorConsistency::learn(const control::DrivenInterval &interval, double voltage_Vs,
                             double mean_A) noexcept {
    const double size_A = std::abs(mean_A);
    const double T = interval.duration_s;
    if (level_) {
        const double rise_per_s = motor_.resistance_rise_per_K * motor_.resistance_Ohm;
        const double heat_K_per_s = mean_A * mean_A * 1.5 * motor_.resistance_Ohm *
                                    motor_.thermal.winding_housing_K_per_W /
                                    motor_.thermal.winding_time_s;
        const double ripple_Ohm = kRippleSlope * motor_.commutation_ripple *
                                  motor_.commutator_segments * motor_.resistance_Ohm *
                                  std::abs(interval.after_rad - interval.before_rad);
        const double cooled_Ohm = rise_per_s * kCooling_K_per_s * T;
        const double heated_Ohm = rise_per_s * heat_K_per_s * T;
        level_->mean_Ohm = level_->mean_Ohm.wider(cooled_Ohm, heated_Ohm);
        level_->here_Ohm = level_->here_Ohm.wider(cooled_Ohm + ripple_Ohm, heated_Ohm + ripple_Ohm);
    }
    const bool is_same = window_.duration_s > 0.0 && mean_A * window_.charge_As > 0.0;
    if (!(size_A > kLevel_A)) {
        window_ = {};
        return;
    }
    if (!is_same) {
        window_ = {};
        window_.min_A = window_.max_A = size_A;
    }
    window_.duration_s += T;
    window_.voltage_Vs += voltage_Vs;
    window_.charge_As += mean_A * T;
    window_.turned_rad += interval.after_rad - interval.before_rad;
    window_.min_A = std::min(window_.min_A, size_A);
    window_.max_A = std::max(window_.max_A, size_A);
    if (window_.max_A > (1.0 + kSteady) * window_.min_A) {
        window_ = {};
    } else if (window_.duration_s >= kWindow_s) {
        end_window();
        window_ = {};
    }
}

/// Intersects what is known at this level with what the window says.
void MotorConsistency::end_window() noexcept {
    const double mean_A = window_.charge_As / window_.duration_s;
    const double size_A = std::abs(mean_A);
    const double turned_V =
        motor_.torque_constant_Nm_per_A * window_.turned_rad / window_.duration_s;
    const double drop_V =
        std::copysign(1.0, mean_A) * (window_.voltage_Vs / window_.duration_s - turned_V);
    const double off_V = k_T_tolerance_ * std::abs(turned_V) + kNoise_V;
    const Bounds seen_Ohm{(drop_V - off_V) / size_A, (drop_V + off_V) / size_A};
    const Bounds of_mean_Ohm = seen_Ohm.wider(ripple_Ohm_, ripple_Ohm_);
    if (!level_ || level_->current_A * mean_A <= 0.0) {
        level_ = Level{mean_A, seen_Ohm, of_mean_Ohm};
        return;
    }
    level_ = Level{mean_A, apparent_Ohm(mean_A).and_also(seen_Ohm),
                   at_current(mean_A, level_->mean_Ohm).and_also(of_mean_Ohm)};
}

} // namespace springdrive::servo
