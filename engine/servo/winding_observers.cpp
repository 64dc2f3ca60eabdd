#include "engine/servo/winding_observers.h"

#include "engine/servo/bumpless_transfer.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace springdrive::servo {

namespace {

/// Until an observation is settled, the mean of R is taken to deviate by this share of it: a sensor
/// that fails then would not be noticed at once.
constexpr double kUnsettled = 0.05;

/// How fast what is used of k_T, as a share of it, of the current's offset and of V_b approach what
/// was learned: R̂ times the offset is a voltage, too, and so is a share of e_W.
constexpr double kMaxChangeOfShare_per_s = 0.2;
constexpr double kMaxChange_A_per_s = 0.2;
constexpr double kMaxBrushChange_V_per_s = 1.0;

/// Near the peak current an amplifier may cut it off.
constexpr double kWithinPeak = 0.95;

[[nodiscard]] double limited_step(double from, double to, double most) noexcept {
    return std::clamp(to, from - most, from + most);
}

control::ObservedMotor unobserved(device::DeviceDescription device, std::size_t motor) {
    device.calibration.reset(); // it may be the calibration that is wrong
    return used_at_start(device, motor);
}

} // namespace

control::ObservedMotor used_at_start(const device::DeviceDescription &device, std::size_t motor) {
    control::ObservedMotor known = control::known_at_start(device, motor);
    if (device.motor[motor].resistance_tolerance > 0.0) {
        known.mean.deviation_Ohm =
            std::max(known.mean.deviation_Ohm, kUnsettled * known.mean.resistance_Ohm);
    }
    return known;
}

WindingObservers::WindingObservers(const device::DeviceDescription &device, double delay_periods,
                                   double period_s)
    : period_s_(period_s),
      // R̂ follows R less so many deviations, all of which may change at once
      max_rate_Ohm_per_s_(max_resistance_change_Ohm_per_s(device) /
                          (1.0 + control::kHeldUpDeviations)),
      whole_delay_(whole_delay(delay_periods)),
      delay_fraction_(delay_periods - std::floor(delay_periods)),
      observer_{control::WindingObserver(device, 0, period_s),
                control::WindingObserver(device, 1, period_s),
                control::WindingObserver(device, 2, period_s)},
      motor_(device.motor), unobserved_{unobserved(device, 0), unobserved(device, 1),
                                        unobserved(device, 2)},
      used_(control::motors_of_file(device.motor)) {}

std::size_t WindingObservers::whole_delay(double delay_periods) noexcept {
    return delay_periods <= static_cast<double>(kMaxDelay) ? static_cast<std::size_t>(delay_periods)
                                                           : kHistory;
}

void WindingObservers::set_timing(double delay_periods, double period_s) noexcept {
    period_s_ = period_s;
    whole_delay_ = whole_delay(delay_periods);
    delay_fraction_ = delay_periods - std::floor(delay_periods);
    known_commands_ = 0; // delays were of another period
    has_previous_ = false;
    for (control::WindingObserver &observer : observer_) {
        observer.set_period(period_s);
    }
}

void WindingObservers::restart() noexcept {
    for (control::WindingObserver &observer : observer_) {
        observer.restart();
    }
    is_restarted_ = true;
    has_previous_ = false;
}

const device::DeviceCommand &WindingObservers::command_before(std::size_t ticks) const noexcept {
    return history_[(newest_ + kHistory - ticks) % kHistory];
}

void WindingObservers::record(const device::DeviceCommand &command) noexcept {
    newest_ = (newest_ + 1) % kHistory;
    history_[newest_] = command;
    known_commands_ = std::min(known_commands_ + 1, kHistory);
}

void WindingObservers::skip_observers(const Vector3 &current_A,
                                      std::uint32_t missed_periods) noexcept {
    for (std::size_t j = 0; j < observer_.size(); ++j) {
        observer_[j].skip(current_A[static_cast<Eigen::Index>(j)], missed_periods + 1);
    }
}

void WindingObservers::rest(const device::Measurement &measured, const Vector3 &theta_rad,
                            bool is_next, std::uint32_t missed_periods) noexcept {
    static_cast<void>(find_intervals(measured, theta_rad, is_next));
    skip_observers(measured.current_A, missed_periods);
    const double step_Ohm = max_rate_Ohm_per_s_ * period_s_;
    for (std::size_t j = 0; j < observer_.size(); ++j) {
        control::ObservedMotor &used = used_[j];
        const double R_Ohm = motor_[j].resistance_Ohm;
        const auto approach_file = [&](control::ResistanceEstimate &estimate) {
            estimate = {limited_step(estimate.resistance_Ohm, R_Ohm, step_Ohm),
                        limited_step(estimate.deviation_Ohm, 0.0, step_Ohm)};
            return estimate.resistance_Ohm == R_Ohm && estimate.deviation_Ohm == 0.0;
        };
        const bool is_here = approach_file(used.here);
        const bool is_mean = approach_file(used.mean);
        approach_constants(control::motor_of_file(motor_[j]), used);
        const bool are_constants =
            used.torque_constant_Nm_per_A == motor_[j].torque_constant_Nm_per_A &&
            used.offset_A == 0.0 && used.brush_voltage_V == 0.0;
        used.is_observed = used.is_observed && !(is_here && is_mean && are_constants);
        used.is_trusted = true;
    }
}

void WindingObservers::update(const device::Measurement &measured, const Vector3 &theta_rad,
                              bool is_next, std::uint32_t missed_periods) noexcept {
    control::ObservedMotors before;
    for (std::size_t j = 0; j < before.size(); ++j) {
        before[j] = known_of(j, theta_rad[static_cast<Eigen::Index>(j)]);
    }
    if (find_intervals(measured, theta_rad, is_next)) {
        for (std::size_t j = 0; j < observer_.size(); ++j) {
            if (interval_[j]) {
                observer_[j].update(*interval_[j]);
            } else {
                observer_[j].skip(measured.current_A[static_cast<Eigen::Index>(j)]);
            }
        }
    } else {
        skip_observers(measured.current_A, missed_periods);
    }
    approach(theta_rad, before);
}

/// With the commands that acted in the last period: the older one until a fraction of it. The
/// newest of them was recorded after the last measurement.
bool WindingObservers::find_intervals(const device::Measurement &measured, const Vector3 &theta_rad,
                                      bool is_next) noexcept {
    interval_.fill(std::nullopt);
    const std::size_t needed = whole_delay_ + (delay_fraction_ > 0.0 ? 2 : 1);
    const bool is_known = is_next && has_previous_ && known_commands_ >= needed;
    const Vector3 before_A = std::exchange(current_A_, measured.current_A);
    const Vector3 before_rad = std::exchange(theta_rad_, theta_rad);
    known_commands_ = is_next ? known_commands_ : 0;
    has_previous_ = true;
    if (!is_known) {
        return false;
    }
    const device::DeviceCommand &newer = command_before(whole_delay_);
    const device::DeviceCommand &older =
        delay_fraction_ > 0.0 ? command_before(whole_delay_ + 1) : newer;
    using Value = const Vector3 device::DeviceCommand::*;
    const auto driven = [](const device::DeviceCommand &command, Value value, Eigen::Index j) {
        return command.mode == device::CommandMode::drive ? (command.*value)[j] : 0.0;
    };
    const auto acted = [&](Value value, Eigen::Index j) {
        return (1.0 - delay_fraction_) * driven(newer, value, j) +
               delay_fraction_ * driven(older, value, j);
    };
    const auto step_V = [&](Eigen::Index j) {
        return driven(newer, &device::DeviceCommand::e_W_V, j) -
               driven(older, &device::DeviceCommand::e_W_V, j);
    };
    const bool is_open =
        newer.mode == device::CommandMode::open || older.mode == device::CommandMode::open;
    for (std::size_t motor = 0; motor < observer_.size(); ++motor) {
        const auto j = static_cast<Eigen::Index>(motor);
        const double limit_A = kWithinPeak * motor_[motor].peak_current_A;
        if (!is_open && !measured.faults.any() && std::abs(before_A[j]) < limit_A &&
            std::abs(current_A_[j]) < limit_A) {
            interval_[motor] = {period_s_,
                                acted(&device::DeviceCommand::e_W_V, j),
                                step_V(j),
                                delay_fraction_,
                                acted(&device::DeviceCommand::cancelled_resistance_Ohm, j),
                                before_A[j],
                                current_A_[j],
                                before_rad[j],
                                theta_rad_[j]};
        }
    }
    return true;
}

bool WindingObservers::are_trusted() const noexcept {
    return std::ranges::all_of(observer_, &control::WindingObserver::is_trusted);
}

/// What is known of a motor under the verdict on all three.
control::ObservedMotor WindingObservers::known_of(std::size_t motor,
                                                  double theta_rad) const noexcept {
    if (!are_trusted()) {
        return unobserved_[motor];
    }
    const control::WindingObserver &observer = observer_[motor];
    control::ObservedMotor known = observer.motor(theta_rad);
    if (motor_[motor].resistance_tolerance != 0.0 && !observer.is_settled()) {
        known.mean.deviation_Ohm =
            std::max(known.mean.deviation_Ohm, kUnsettled * known.mean.resistance_Ohm);
    }
    return known;
}

/// Takes k_T, offset and V_b a tick nearer to what is known.
void WindingObservers::approach_constants(const control::ObservedMotor &known,
                                          control::ObservedMotor &used) const noexcept {
    double &k_T = used.torque_constant_Nm_per_A;
    k_T = limited_step(k_T, known.torque_constant_Nm_per_A,
                       kMaxChangeOfShare_per_s * period_s_ * k_T);
    used.offset_A = limited_step(used.offset_A, known.offset_A, kMaxChange_A_per_s * period_s_);
    const double step_V = kMaxBrushChange_V_per_s * period_s_;
    used.brush_voltage_V = limited_step(used.brush_voltage_V, known.brush_voltage_V, step_V);
    used.brush_deviation_V = limited_step(used.brush_deviation_V, known.brush_deviation_V, step_V);
}

/// Estimates become better in steps, the force must not: what a step was is carried, and taken back
/// slowly. What is left of it is a deviation, too.
/// @param before  what was known at these angles before the estimates became better
void WindingObservers::approach(const Vector3 &theta_rad,
                                const control::ObservedMotors &before) noexcept {
    const double step_Ohm = max_rate_Ohm_per_s_ * period_s_;
    const bool used_observations = std::exchange(uses_observations_, are_trusted());
    const bool is_restarted = std::exchange(is_restarted_, false);
    const bool is_another_kind = is_restarted || used_observations != uses_observations_;
    for (std::size_t j = 0; j < observer_.size(); ++j) {
        const auto index = static_cast<Eigen::Index>(j);
        const control::ObservedMotor now = known_of(j, theta_rad[index]);
        control::ObservedMotor &used = used_[j];
        const auto approach_estimate = [&](control::ResistanceEstimate &estimate,
                                           double &offset_Ohm,
                                           const control::ResistanceEstimate &known,
                                           const control::ResistanceEstimate &known_before) {
            offset_Ohm = !used.is_observed || is_another_kind
                             ? estimate.resistance_Ohm - known.resistance_Ohm
                             : offset_Ohm + known_before.resistance_Ohm - known.resistance_Ohm;
            offset_Ohm = limited_step(offset_Ohm, 0.0, step_Ohm);
            const double deviation_Ohm = std::max(known.deviation_Ohm, std::abs(offset_Ohm));
            estimate = {known.resistance_Ohm + offset_Ohm,
                        limited_step(estimate.deviation_Ohm, deviation_Ohm, step_Ohm)};
        };
        approach_estimate(used.here, transfer_offset_here_Ohm_[index], now.here, before[j].here);
        approach_estimate(used.mean, transfer_offset_mean_Ohm_[index], now.mean, before[j].mean);
        approach_constants(now, used);
        used.is_observed = true;
        used.is_trusted = observer_[j].is_trusted();
    }
}

} // namespace springdrive::servo
