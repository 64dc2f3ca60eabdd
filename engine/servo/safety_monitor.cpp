#include "engine/servo/safety_monitor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace springdrive {

namespace {

/// From nothing to the full command.
constexpr double kRampTime_s = 0.5;

/// The force limit is one of lasting force; the shock of hitting a stiff surface is shorter, and
/// the current limit bounds it.
constexpr double kForceTolerated_s = 0.02;

WindingGuard guard_of(const DeviceDescription &device, std::size_t motor, double period_s) {
    return {device.motor[motor], device.amplifier.greatest_cancelled_Ohm, period_s};
}

} // namespace

std::string description(const SafetyStatus &status) {
    const auto crossed = [&status](const char *what, const char *unit) {
        std::array<char, 96> text{};
        std::snprintf(text.data(), text.size(), "%s %.2f %s, limit %.2f %s", what, status.measured,
                      unit, status.limit, unit);
        return std::string(text.data());
    };
    switch (status.cause) {
    case TripCause::none:
        return "no trip";
    case TripCause::emergency_stop:
        return "emergency stop";
    case TripCause::device_lost:
        return "the device does not answer";
    case TripCause::not_finite:
        return "a value that is not finite";
    case TripCause::tip_speed:
        return crossed("tip speed", "m/s");
    case TripCause::tip_force:
        return crossed("tip force", "N");
    case TripCause::current:
        return crossed("winding current", "A");
    case TripCause::winding_temperature:
        return crossed("winding temperature, upper estimate,", "°C");
    }
    return "unknown";
}

SafetyMonitor::SafetyMonitor(DeviceDescription device, double period_s)
    : device_(std::move(device)),
      period_s_(period_s), guard_{guard_of(device_, 0, period_s), guard_of(device_, 1, period_s),
                                  guard_of(device_, 2, period_s)} {}

void SafetyMonitor::watch_windings(const Vector3 &current_A) noexcept {
    for (std::size_t j = 0; j < guard_.size(); ++j) {
        guard_[j].update(current_A[static_cast<Eigen::Index>(j)]);
        winding_[j] = {guard_[j].least_C(), guard_[j].greatest_C(),
                       guard_[j].greatest_cancelled_Ohm(), false};
    }
}

void SafetyMonitor::trip(TripCause cause, double measured, double limit) noexcept {
    if (status_.state != SafetyState::tripped) {
        status_ = {SafetyState::tripped, cause, measured, limit, 0.0};
    }
}

void SafetyMonitor::reset() noexcept {
    if (status_.state == SafetyState::tripped) {
        status_ = {};
        ticks_above_force_limit_ = 0;
    }
}

void SafetyMonitor::check(const DeviceCommand &wanted, const Measurement &measured,
                          bool emergency_stop) noexcept {
    if (emergency_stop) {
        trip(TripCause::emergency_stop, 0.0, 0.0);
    }
    if (measured.health != DeviceHealth::ok) {
        trip(TripCause::device_lost, 0.0, 0.0);
    }
    if (!measured.all_finite || !wanted.e_W_V.allFinite() ||
        !wanted.cancelled_resistance_Ohm.allFinite() || !measured.current_A.allFinite() ||
        !measured.tip_velocity_m_per_s.allFinite() || !measured.tip_force_N.allFinite()) {
        trip(TripCause::not_finite, 0.0, 0.0);
        return;
    }
    const double speed = measured.tip_velocity_m_per_s.norm();
    if (speed > device_.limits.tip_speed_m_per_s) {
        trip(TripCause::tip_speed, speed, device_.limits.tip_speed_m_per_s);
    }
    const double force = measured.tip_force_N.norm();
    ticks_above_force_limit_ =
        force > device_.limits.tip_force_N ? ticks_above_force_limit_ + 1 : 0;
    if (ticks_above_force_limit_ * period_s_ > kForceTolerated_s + 0.5 * period_s_) {
        trip(TripCause::tip_force, force, device_.limits.tip_force_N);
    }
    for (std::size_t j = 0; j < winding_.size(); ++j) {
        const MotorParameters &motor = device_.motor[j];
        const double current_A = std::abs(measured.current_A[static_cast<Eigen::Index>(j)]);
        if (current_A > motor.peak_current_A) {
            trip(TripCause::current, current_A, motor.peak_current_A);
        }
        if (winding_[j].greatest_C > motor.thermal.greatest_winding_C) {
            trip(TripCause::winding_temperature, winding_[j].greatest_C,
                 motor.thermal.greatest_winding_C);
        }
    }
}

DeviceCommand SafetyMonitor::pass(const DeviceCommand &wanted, const Measurement &measured,
                                  bool emergency_stop) noexcept {
    watch_windings(measured.current_A); // tripped or not, they warm and cool
    check(wanted, measured, emergency_stop);
    if (status_.state == SafetyState::tripped) {
        return DeviceCommand::braking();
    }
    status_.ramp = std::min(1.0, status_.ramp + period_s_ / kRampTime_s);
    status_.state = status_.ramp < 1.0 ? SafetyState::starting : SafetyState::running;

    DeviceCommand command;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const double supply_V = device_.motor[static_cast<std::size_t>(j)].supply_V;
        WindingStatus &winding = winding_[static_cast<std::size_t>(j)];
        const double asked_Ohm = status_.ramp * wanted.cancelled_resistance_Ohm[j];
        command.e_W_V[j] = std::clamp(status_.ramp * wanted.e_W_V[j], -supply_V, supply_V);
        // Whoever asks for less residual resistance does not get it (7).
        command.cancelled_resistance_Ohm[j] = std::clamp(asked_Ohm, 0.0, winding.R_hat_limit_Ohm);
        winding.is_limited = asked_Ohm > winding.R_hat_limit_Ohm;
    }
    return command;
}

} // namespace springdrive
