#include "engine/servo/winding_observers.h"

#include "engine/servo/bumpless_transfer.h"

#include <algorithm>
#include <cmath>

namespace springdrive::servo {

namespace {

/// Near the peak current an amplifier may cut it off.
constexpr double kWithinPeak = 0.95;

[[nodiscard]] double limited_step(double from, double to, double most) noexcept {
    return std::clamp(to, from - most, from + most);
}

/// R̂ i is a voltage: even at the peak current it changes no faster than tuning changes e_W.
[[nodiscard]] double max_rate(const device::DeviceDescription &device) {
    double peak_A = 0.0;
    for (const device::MotorParameters &motor : device.motor) {
        peak_A = std::max(peak_A, motor.peak_current_A);
    }
    return kMaxChange_V_per_s / peak_A;
}

} // namespace

WindingObservers::WindingObservers(const device::DeviceDescription &device, double delay_periods,
                                   double period_s)
    : period_s_(period_s), max_rate_Ohm_per_s_(max_rate(device)),
      whole_delay_(static_cast<std::size_t>(
          std::clamp(delay_periods, 0.0, static_cast<double>(kLongestDelay) + 1.0))),
      delay_fraction_(delay_periods - std::floor(delay_periods)),
      observer_{control::ResistanceObserver(device, 0, period_s),
                control::ResistanceObserver(device, 1, period_s),
                control::ResistanceObserver(device, 2, period_s)},
      motor_(device.motor) {
    restart();
}

void WindingObservers::set_period(double period_s) noexcept {
    period_s_ = period_s;
    known_commands_ = 0; // delays were of another period
    for (control::ResistanceObserver &observer : observer_) {
        observer.set_period(period_s);
    }
}

void WindingObservers::restart() noexcept {
    for (std::size_t j = 0; j < observer_.size(); ++j) {
        observer_[j].restart();
        resistances_[j] = observer_[j].resistance(theta_rad_[static_cast<Eigen::Index>(j)]);
    }
}

const device::DeviceCommand &WindingObservers::command_before(std::size_t ticks) const noexcept {
    return history_[(newest_ + kHistory - ticks) % kHistory];
}

void WindingObservers::note(const device::DeviceCommand &command) noexcept {
    newest_ = (newest_ + 1) % kHistory;
    history_[newest_] = command;
    known_commands_ = std::min(known_commands_ + 1, kHistory);
}

void WindingObservers::rest(const Vector3 &current_A, std::uint32_t missed_periods) noexcept {
    known_commands_ = 0;
    for (std::size_t j = 0; j < observer_.size(); ++j) {
        observer_[j].skip(current_A[static_cast<Eigen::Index>(j)], missed_periods + 1);
    }
}

void WindingObservers::take(const device::Measurement &measured, const Vector3 &theta_rad,
                            bool is_next, std::uint32_t missed_periods) noexcept {
    // The commands of the last period, the newest of which was noted after the last measurement.
    const std::size_t needed = whole_delay_ + (delay_fraction_ > 0.0 ? 2 : 1);
    if (is_next && known_commands_ >= needed) {
        learn(measured, theta_rad);
    } else {
        const std::size_t known = is_next ? known_commands_ : 0;
        rest(measured.current_A, missed_periods);
        known_commands_ = known;
    }
    current_A_ = measured.current_A;
    theta_rad_ = theta_rad;
    approach(theta_rad);
}

/// With the commands that acted in the last period: the older one until a fraction of it.
void WindingObservers::learn(const device::Measurement &measured,
                             const Vector3 &theta_rad) noexcept {
    const device::DeviceCommand &newer = command_before(whole_delay_);
    const device::DeviceCommand &older =
        delay_fraction_ > 0.0 ? command_before(whole_delay_ + 1) : newer;
    const auto acted = [&](const Vector3 device::DeviceCommand::*value, Eigen::Index j) {
        const auto of = [&](const device::DeviceCommand &command) {
            return command.mode == device::CommandMode::drive ? (command.*value)[j] : 0.0;
        };
        return (1.0 - delay_fraction_) * of(newer) + delay_fraction_ * of(older);
    };
    const bool is_open =
        newer.mode == device::CommandMode::open || older.mode == device::CommandMode::open;
    for (std::size_t j = 0; j < observer_.size(); ++j) {
        const auto index = static_cast<Eigen::Index>(j);
        const double before_A = current_A_[index];
        const double after_A = measured.current_A[index];
        const double limit_A = kWithinPeak * motor_[j].peak_current_A;
        if (is_open || measured.faults.any() || !(std::abs(before_A) < limit_A) ||
            !(std::abs(after_A) < limit_A)) {
            observer_[j].skip(after_A);
            continue;
        }
        observer_[j].update({period_s_, acted(&device::DeviceCommand::e_W_V, index),
                             acted(&device::DeviceCommand::cancelled_resistance_Ohm, index),
                             before_A, after_A, theta_rad_[index], theta_rad[index]});
    }
}

/// Estimates become better in steps, the force must not. A worse one applies at once, and what is
/// left of the way to a better one is a deviation, too.
void WindingObservers::approach(const Vector3 &theta_rad) noexcept {
    const double step_Ohm = max_rate_Ohm_per_s_ * period_s_;
    for (std::size_t j = 0; j < observer_.size(); ++j) {
        const control::WindingResistance now =
            observer_[j].resistance(theta_rad[static_cast<Eigen::Index>(j)]);
        control::WindingResistance &used = resistances_[j];
        const double mean_Ohm =
            limited_step(used.mean.resistance_Ohm, now.mean.resistance_Ohm, step_Ohm);
        const double gap_Ohm = std::abs(mean_Ohm - now.mean.resistance_Ohm);
        const auto deviation = [&](double from_Ohm, double to_Ohm) {
            return std::max({to_Ohm, from_Ohm - step_Ohm, gap_Ohm});
        };
        used = {{mean_Ohm + now.here.resistance_Ohm - now.mean.resistance_Ohm,
                 deviation(used.here.deviation_Ohm, now.here.deviation_Ohm)},
                {mean_Ohm, deviation(used.mean.deviation_Ohm, now.mean.deviation_Ohm)},
                true,
                now.is_trusted};
    }
}

} // namespace springdrive::servo
