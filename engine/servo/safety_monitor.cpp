#include "engine/servo/safety_monitor.h"

#include "device/core/phantom/kinematics.h"
#include "engine/servo/bumpless_transfer.h"
#include "engine/servo/safety_limits.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace springdrive::servo {

namespace {

/// Between ticks a tip may move by this factor times its maximum speed, plus this many counts; a
/// larger displacement is an encoder error.
constexpr double kJumpFactor = 1.5;
constexpr double kJumpCounts = 3.0;

/// Tolerates round-off when a number of periods adds up to exactly a limit in seconds.
constexpr double kRoundOff = 1e-9;

/// An observed R is within so many standard deviations: one in 16,000 is not.
constexpr double kObservedDeviations = 4.0;

/// An observation counts once its standard deviation is below this share of R.
constexpr double kObserved = 0.02;

/// Above this share of the supply an amplifier may do less than it is told.
constexpr double kWithinSupply = 0.9;

/// Of the standard deviation of a difference of two currents: none is more.
constexpr double kNoiseDeviations = 6.0;

device::WindingGuard guard_of(const device::DeviceDescription &device, std::size_t motor,
                              double period_s) {
    return {device.motor[motor], device.amplifier.max_cancelled_Ohm, period_s,
            device.resistance_tolerance(motor)};
}

device::WindingBalance balance_of(const device::DeviceDescription &device, std::size_t motor,
                                  double period_s) {
    const device::MotorParameters &file = device.motor[motor];
    const device::CurrentSensing &sensing = device.current_sensing;
    const double hot_Ohm = (1.0 + device.resistance_tolerance(motor)) *
                           device::max_resistance_Ohm(file, file.thermal.max_winding_C);
    const double noise_A = kNoiseDeviations * std::sqrt(2.0) * sensing.noise_A;
    return device::WindingBalance(
        {static_cast<float>(hot_Ohm), static_cast<float>(file.inductance_H),
         static_cast<float>(file.torque_constant_Nm_per_A),
         static_cast<float>(device.rad_per_count()),
         static_cast<float>(noise_A + sensing.resolution_A),
         static_cast<float>(sensing.max_offset_A), static_cast<float>(kDelay_periods * period_s),
         static_cast<float>(file.max_brush_voltage_V), sensing.is_shared});
}

double latched(device::BoardFaults faults) { return faults.bits & ~device::BoardFaults::kPressed; }

double max_step_m(const device::DeviceDescription &device, double speed_limit_m_per_s,
                  double time_s, const Matrix3 &J) {
    return kJumpFactor * speed_limit_m_per_s * time_s +
           kJumpCounts * device.rad_per_count() * J.norm();
}

} // namespace

SafetyMonitor::SafetyMonitor(device::DeviceDescription device, double period_s)
    : device_(std::move(device)), period_s_(period_s), device_limits_(limits_of(device_)),
      limits_(device_limits_), max_R_hat_rate_Ohm_per_s_(max_resistance_change_Ohm_per_s(device_)),
      guard_{guard_of(device_, 0, period_s), guard_of(device_, 1, period_s),
             guard_of(device_, 2, period_s)},
      balance_{balance_of(device_, 0, period_s), balance_of(device_, 1, period_s),
               balance_of(device_, 2, period_s)},
      consistency_{MotorConsistency(device_, 0, period_s), MotorConsistency(device_, 1, period_s),
                   MotorConsistency(device_, 2, period_s)},
      energy_(period_s), rest_(period_s) {
    for (std::size_t j = 0; j < guard_.size(); ++j) {
        winding_[j].R_hat_limit_Ohm = guard_[j].max_cancelled_Ohm();
    }
}

void SafetyMonitor::set_period(double period_s) noexcept {
    period_s_ = period_s;
    for (device::WindingGuard &guard : guard_) {
        guard.set_period(period_s);
    }
    for (device::WindingBalance &balance : balance_) {
        balance.set_delay(static_cast<float>(kDelay_periods * period_s));
        balance.forget();
    }
    for (MotorConsistency &motor : consistency_) {
        motor.set_period(period_s);
    }
    energy_.set_period(period_s);
    rest_.set_period(period_s);
}

bool SafetyMonitor::reset(std::uint32_t released_stop) noexcept {
    if (status_.state != SafetyState::tripped || is_final(status_.cause) ||
        status_.held_stop > released_stop) {
        return false;
    }
    for (device::WindingGuard &guard : guard_) {
        guard.forget_observations();
    }
    for (device::WindingBalance &balance : balance_) {
        balance.reset();
    }
    status_ = {};
    board_reset_left_s_ = board_has_faults_ ? kBoardReset_s : 0.0;
    clears_board_ = true;
    cut_off_s_ = 0.0;
    rest_.reset();
    energy_.reset();
    return true;
}

device::DeviceCommand SafetyMonitor::fail(const AssertionFailure &failure) noexcept {
    if (!is_final(status_.cause)) { // keep the first failure; later ones follow from it
        status_ = {SafetyState::tripped, TripCause::assertion, 0.0, 0.0, 0.0, failure,
                   status_.held_stop};
    }
    return safe_state();
}

void SafetyMonitor::trip(TripCause cause, double measured, double limit) noexcept {
    if (status_.state != SafetyState::tripped) {
        status_ = {SafetyState::tripped, cause, measured, limit, 0.0, {}, status_.held_stop};
        board_reset_left_s_ = 0.0;
    }
}

/// NaN counts as above every limit.
void SafetyMonitor::trip_above(TripCause cause, double measured, double limit) noexcept {
    if (!(measured <= limit)) {
        trip(cause, measured, limit);
    }
}

/// Beyond such a limit the counts are not those of the mechanism: their zero is void.
void SafetyMonitor::trip_counts_above(TripCause cause, double measured, double limit) noexcept {
    voids_zero_ = voids_zero_ || measured > limit;
    trip_above(cause, measured, limit);
}

void SafetyMonitor::approach_limits(const SafetyLimits &requested) noexcept {
    const SafetyLimits before = limits_;
    limits_ = lowered(device_limits_, requested);
    if (!lets_pass()) {
        return; // no motor is driven, so limits may step
    }
    for (double SafetyLimits::*const limit :
         {&SafetyLimits::voltage_V, &SafetyLimits::current_A, &SafetyLimits::tip_force_N}) {
        const double step = device_limits_.*limit * period_s_ / kLimitGlide_s;
        limits_.*limit = std::clamp(limits_.*limit, before.*limit - step, before.*limit + step);
    }
}

void SafetyMonitor::watch_windings(const Observation &seen) noexcept {
    for (std::size_t j = 0; j < guard_.size(); ++j) {
        device::WindingGuard &guard = guard_[j];
        guard.update(seen.current_A[static_cast<Eigen::Index>(j)], seen.missed_periods);
        if (!seen.motors[j].is_observed || !seen.motors[j].is_trusted) {
            guard.forget_observations();
        } else if (const auto &[R_Ohm, deviation_Ohm] = seen.unheated[j];
                   deviation_Ohm < kObserved * R_Ohm) {
            const double to_both_sides_Ohm = kObservedDeviations * deviation_Ohm;
            guard.narrow({R_Ohm - to_both_sides_Ohm, R_Ohm + to_both_sides_Ohm});
        }
        const double before_Ohm = winding_[j].R_hat_limit_Ohm;
        const double step_Ohm = max_R_hat_rate_Ohm_per_s_ * period_s_;
        const double limit_Ohm = std::min(
            std::clamp(guard.max_cancelled_Ohm(), before_Ohm - step_Ohm, before_Ohm + step_Ohm),
            static_cast<double>(balance_[j].limit_Ohm()));
        const bool generates = balance_[j].generates();
        winding_[j] = {guard.min_C(),
                       guard.max_C(),
                       limit_Ohm,
                       false,
                       guard.is_contradicted() || generates,
                       generates,
                       guard.hottest().housing_C};
    }
}

/// Where a channel is at its supply, amplifiers may pass on less of all voltages: of one against
/// the current that would look as if the winding drove itself.
void SafetyMonitor::watch_balances(const Observation &seen) noexcept {
    bool is_cut_off = false;
    for (std::size_t j = 0; j < balance_.size(); ++j) {
        if (const auto &interval = seen.interval[j]) {
            const double largest_A =
                std::max(std::abs(interval->before_A), std::abs(interval->after_A));
            is_cut_off = is_cut_off || std::abs(interval->e_W_V) + std::abs(interval->e_W_step_V) +
                                               interval->R_hat_Ohm * largest_A >
                                           kWithinSupply * device_.motor[j].supply_V;
        }
    }
    for (std::size_t j = 0; j < balance_.size(); ++j) {
        const auto &interval = seen.interval[j];
        if (!interval || !seen.has_inductance) {
            balance_[j].forget();
            continue;
        }
        const double sign = std::copysign(1.0, interval->after_A);
        const double least_A = std::min(sign * interval->before_A, sign * interval->after_A);
        const double along_V =
            sign * interval->e_W_V - std::abs(interval->e_W_step_V) + interval->R_hat_Ohm * least_A;
        if (is_cut_off && !(along_V > 0.0)) {
            balance_[j].forget();
            continue;
        }
        const double last_V = interval->e_W_V + interval->step_at * interval->e_W_step_V;
        balance_[j].update({static_cast<float>(interval->duration_s),
                            static_cast<float>(interval->e_W_V), static_cast<float>(last_V),
                            static_cast<float>(passed_e_W_V_[static_cast<Eigen::Index>(j)]),
                            static_cast<float>(interval->R_hat_Ohm),
                            static_cast<float>(interval->before_A),
                            static_cast<float>(interval->after_A),
                            static_cast<float>(interval->after_rad - interval->before_rad)});
    }
}

void SafetyMonitor::resume_watch(const std::array<device::MotorTemperature, 3> &hottest) noexcept {
    for (std::size_t j = 0; j < guard_.size(); ++j) {
        guard_[j].resume(hottest[j]);
        balance_[j].forget();
        winding_[j].R_hat_limit_Ohm =
            std::min(winding_[j].R_hat_limit_Ohm, guard_[j].max_cancelled_Ohm());
    }
}

void SafetyMonitor::watch_window(const SafetyOrders &orders, double elapsed_s) noexcept {
    const bool beats = orders.heartbeat != heartbeat_ || orders.heartbeat == 0;
    heartbeat_ = orders.heartbeat;
    window_silent_s_ = beats ? 0.0 : window_silent_s_ + elapsed_s;
}

/// A late measurement is new, but does not show that the device keeps up. Only a new measurement
/// can clear a fault.
void SafetyMonitor::watch_link(const Link &link, double elapsed_s) noexcept {
    stale_s_ = link.arrival == device::Arrival::fresh ? 0.0 : stale_s_ + elapsed_s;
    amplifier_is_at_fault_ = link.faults.has(device::BoardFaults::kAmplifier) ||
                             (amplifier_is_at_fault_ && !device::is_new(link.arrival));
    board_has_faults_ = link.faults.any() || (board_has_faults_ && !device::is_new(link.arrival));
    clears_board_ = clears_board_ && device::is_new(link.arrival) && elapsed_s < 1.5 * period_s_;
    const double left_s = board_reset_left_s_ - elapsed_s;
    board_reset_left_s_ = board_has_faults_ && left_s > kRoundOff ? left_s : 0.0;
    if (link.zeroing != zeroing_) { // of which the counts before know nothing
        zeroing_ = link.zeroing;
        has_tip_ = has_tip_ && lets_pass();
    }
    if (zeroing_ == 0 && lets_pass()) {
        status_.state = SafetyState::waiting;
        status_.ramp = 0.0;
    }
}

/// Each press is a stop, also while the board has latched the one before. A switch that stays on
/// after its stop was released and the board was reset is a stop anew.
void SafetyMonitor::watch_stops(const Link &link, const SafetyOrders &orders) noexcept {
    const bool was_on = switch_is_on_;
    const bool was_pressed = switch_is_pressed_;
    const bool is_old = !device::is_new(link.arrival);
    switch_is_on_ = link.faults.has(device::BoardFaults::kStop) || (was_on && is_old);
    switch_is_pressed_ = link.faults.has(device::BoardFaults::kPressed) || (was_pressed && is_old);
    last_stop_ = std::max({last_stop_, orders.requested_stop, orders.released_stop});
    const bool stays_on = status_.held_stop == 0 && !is_resetting_board();
    if ((switch_is_on_ && (!was_on || stays_on)) || (switch_is_pressed_ && !was_pressed)) {
        ++last_stop_;
    }
    if (last_stop_ > orders.released_stop) {
        status_.held_stop = last_stop_;
    }
}

/// The observer runs only while the gains are constant; while they ramp up the spring changes every
/// tick.
void SafetyMonitor::watch_energy(const Observation &seen) noexcept {
    if (status_.state != SafetyState::running) {
        energy_.reset();
        return;
    }
    const auto stored_J = [&](const Vector3 &force_N) {
        return spring_energy_J(force_N, seen.spring_stretch_m, force_share_);
    };
    const double now_J = stored_J(seen.spring_force_N);
    const double before_J =
        seen.scene_is_new ? energy_.stored_J() : stored_J(seen.spring_force_before_N);
    energy_.update(seen.now.tip_m, seen.tip_force_N, now_J, now_J - before_J,
                   limits_.generated_energy_J);
}

/// @param is_released  no motor is driven, and a zeroing may just have made all rates jump
void SafetyMonitor::check_motion(const Observation &seen, bool is_released) noexcept {
    const Vector3 &tip_m = seen.now.tip_m;
    if (has_tip_) {
        trip_counts_above(TripCause::encoder_jump, (tip_m - tip_m_).norm(),
                          max_step_m(device_, device_limits_.tip_speed_m_per_s,
                                     (1.0 + seen.missed_periods) * period_s_, seen.now.J));
    }
    check_consistency(seen);
    check_windings(seen.current_A);
    if (!is_released) {
        trip_above(TripCause::tip_force, seen.tip_force_N.norm(), limits_.tip_force_N);
        trip_above(TripCause::tip_speed, seen.now.tip_velocity_m_per_s().norm(),
                   limits_.tip_speed_m_per_s);
        for (std::size_t j = 0; j < winding_.size(); ++j) {
            trip_above(TripCause::winding_temperature, winding_[j].max_C,
                       std::min(device_.motor[j].thermal.max_winding_C, limits_.winding_C));
        }
    }
    const Vector3 q_rad = device::joint_from_motor(device_.geometry, seen.now.theta_rad);
    trip_counts_above(TripCause::beyond_stops,
                      beyond_limits(device_.joint_limits, q_rad, 0.0).max_excess_rad(),
                      limits_.beyond_stops_rad);
    trip_above(TripCause::energy, energy_.generated_J(), limits_.generated_energy_J);
}

/// Only while motors are driven: elsewhere a wrong encoder moves nothing.
void SafetyMonitor::check_consistency(const Observation &seen) noexcept {
    for (std::size_t j = 0; j < consistency_.size(); ++j) {
        MotorConsistency &motor = consistency_[j];
        if (!lets_pass()) {
            motor.reset();
        } else if (seen.interval[j]) {
            motor.update(*seen.interval[j], winding_[j].min_C, winding_[j].max_C);
            trip_counts_above(TripCause::motor_contradicted, motor.unexplained_rad(),
                              motor.limit_rad());
        }
    }
}

/// Trips on the winding with the largest current relative to its limit.
void SafetyMonitor::check_windings(const Vector3 &current_A) noexcept {
    double worst = 0.0; // current as a share of its limit
    double measured_A = 0.0;
    double limit_A = limits_.current_A;
    for (std::size_t j = 0; j < winding_.size(); ++j) {
        const double its_A = std::abs(current_A[static_cast<Eigen::Index>(j)]);
        const double its_limit_A = std::min(device_.motor[j].peak_current_A, limits_.current_A);
        if (its_A / its_limit_A > worst) {
            worst = its_A / its_limit_A;
            measured_A = its_A;
            limit_A = its_limit_A;
        }
    }
    trip_above(TripCause::current, measured_A, limit_A);
}

/// Sustained clamping means that the supply cannot provide a command that force and current limits
/// allow.
void SafetyMonitor::check_voltage(const LimitedCommand &passed) noexcept {
    cut_off_s_ = passed.active_limits.voltage ? cut_off_s_ + period_s_ : 0.0;
    if (cut_off_s_ > kVoltageTolerated_s + 0.5 * period_s_) {
        Eigen::Index motor = 0;
        static_cast<void>((passed.permissible_e_W_V - passed.command.e_W_V)
                              .cwiseAbs()
                              .maxCoeff(&motor)); // the motor that is clamped most
        trip(TripCause::voltage, std::abs(passed.permissible_e_W_V[motor]),
             std::min(device_.motor[static_cast<std::size_t>(motor)].supply_V, limits_.voltage_V));
    }
}

/// Checks that do not depend on measured values.
void SafetyMonitor::check_link(const Link &link) noexcept {
    if (status_.held_stop != 0) {
        if (switch_is_on_) {
            trip(TripCause::board_fault, latched(link.faults));
        }
        trip(TripCause::emergency_stop);
    }
    if (link.health != device::DeviceHealth::ok) {
        trip(TripCause::device_lost);
    }
    if (link.faults.any() && !is_resetting_board()) {
        trip(TripCause::board_fault, latched(link.faults));
    }
    trip_above(TripCause::stale_measurement, (1.0 - kRoundOff) * stale_s_, limits_.stale_s);
}

void SafetyMonitor::check_clocks(const Link &link) noexcept {
    trip_above(TripCause::missed_deadlines, (1.0 - kRoundOff) * link.missed_in_a_row * period_s_,
               limits_.late_s);
    trip_above(TripCause::window_silent, window_silent_s_, limits_.window_silence_s);
}

void SafetyMonitor::check(const device::DeviceCommand &requested, const Observation &seen,
                          const SafetyOrders &orders) noexcept {
    check_link(seen.link);
    if (!seen.all_finite || !requested.e_W_V.allFinite() ||
        !requested.cancelled_resistance_Ohm.allFinite() || !seen.current_A.allFinite() ||
        !seen.now.tip_m.allFinite() || !seen.now.tip_velocity_m_per_s().allFinite() ||
        !seen.tip_force_N.allFinite() || !seen.spring_force_N.allFinite() ||
        !seen.spring_stretch_m.allFinite()) {
        trip(TripCause::not_finite);
    }
    check_clocks(seen.link);
    if (zeroing_ == 0) { // its angles are not known
        check_windings(seen.current_A);
    } else {
        check_motion(seen, orders.release && status_.state == SafetyState::waiting);
    }
}

/// From waiting via starting to running; on a request to release, via releasing back to waiting.
void SafetyMonitor::proceed(bool release) noexcept {
    if (release && lets_pass()) {
        status_.ramp = std::max(0.0, status_.ramp - period_s_ / kRampTime_s);
        status_.state = status_.ramp > 0.0 ? SafetyState::releasing : SafetyState::waiting;
        return;
    }
    switch (status_.state) {
    case SafetyState::waiting:
        if (!release && rest_.is_at_rest() && !is_resetting_board()) {
            status_.state = SafetyState::starting;
        }
        break;
    case SafetyState::releasing: // no longer requested
    case SafetyState::starting:
        status_.ramp = std::min(1.0, status_.ramp + period_s_ / kRampTime_s);
        status_.state = status_.ramp < 1.0 ? SafetyState::starting : SafetyState::running;
        break;
    case SafetyState::running:
    case SafetyState::tripped:
        break;
    }
}

LimitedCommand SafetyMonitor::apply_limits(const device::DeviceCommand &requested,
                                           const Observation &seen) noexcept {
    LimiterInputs inputs{seen.now,        limits_,     status_.ramp,
                         Vector3::Zero(), seen.motors, seen.trim_V};
    for (std::size_t j = 0; j < winding_.size(); ++j) {
        const auto index = static_cast<Eigen::Index>(j);
        inputs.R_hat_limit_Ohm[index] = winding_[j].R_hat_limit_Ohm;
        // A residual resistance below the winding's safe minimum is not applied (7).
        winding_[j].is_limited =
            status_.ramp * requested.cancelled_resistance_Ohm[index] > winding_[j].R_hat_limit_Ohm;
    }
    return limited(device_, requested, inputs);
}

device::DeviceCommand SafetyMonitor::pass(const device::DeviceCommand &requested,
                                          const Observation &seen,
                                          const SafetyOrders &orders) noexcept {
    approach_limits(orders.limits);
    active_limits_ = {};
    voids_zero_ = false;
    watch_balances(seen); // also while tripped, as the next
    watch_windings(seen);
    passed_e_W_V_.setZero();
    const std::uint32_t unwatched =
        seen.missed_periods - std::min(seen.missed_periods, std::exchange(held_ticks_, 0U));
    const double elapsed_s = (1.0 + unwatched) * period_s_;
    watch_link(seen.link, elapsed_s);
    watch_stops(seen.link, orders);
    watch_window(orders, elapsed_s);
    watch_energy(seen);
    rest_.update(seen.now.tip_m, seen.touching);
    check(requested, seen, orders);
    tip_m_ = seen.now.tip_m;
    has_tip_ = true;
    proceed(orders.release || zeroing_ == 0);
    if (!lets_pass()) {
        return safe_state();
    }
    const LimitedCommand passed = apply_limits(requested, seen);
    check_voltage(passed);
    if (!lets_pass()) {
        return safe_state();
    }
    active_limits_ = passed.active_limits;
    force_share_ = passed.force_share;
    passed_e_W_V_ = passed.command.e_W_V;
    return passed.command;
}

device::DeviceCommand SafetyMonitor::hold(const device::DeviceCommand &active, const Link &link,
                                          const SafetyOrders &orders) noexcept {
    ++held_ticks_;
    voids_zero_ = false;
    watch_link(link, period_s_);
    watch_stops(link, orders);
    watch_window(orders, period_s_);
    check_link(link);
    check_clocks(link);
    return lets_pass() ? active : safe_state();
}

device::DeviceCommand SafetyMonitor::safe_state() const noexcept {
    device::DeviceCommand command = device::DeviceCommand::braking();
    command.resets_faults = is_resetting_board() && clears_board_;
    command.voids_zero = voids_zero_;
    command.mode = amplifier_is_at_fault_ && !command.resets_faults ? device::CommandMode::open
                                                                    : device::CommandMode::brake;
    return command;
}

} // namespace springdrive::servo
