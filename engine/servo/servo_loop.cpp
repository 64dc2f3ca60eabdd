#include "engine/servo/servo_loop.h"

#include "engine/contact/proxy/haptic_surface.h"
#include "engine/control/rendered_force.h"
#include "engine/control/tuning.h"
#include "engine/servo/servo_sample.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

namespace springdrive::servo {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// A device's clock may jump; larger numbers of missed periods are clamped to this.
constexpr double kMaxMissedPeriods = 1e6;

/// A failed assertion abandons a tick without running destructors, see `run_guarded`.
static_assert(std::is_trivially_destructible_v<ServoSample> &&
              std::is_trivially_destructible_v<Observation> &&
              std::is_trivially_destructible_v<LimitedCommand> &&
              std::is_trivially_destructible_v<control::LawOutcome> &&
              std::is_trivially_destructible_v<contact::Proxy>);

} // namespace

ServoLoop::ServoLoop(device::HapticDevice &device, double period_s)
    : device_(device), period_s_(period_s), law_(device.description()),
      transfer_(device.description(), period_s),
      observers_(device.description(), device.delay_periods(), period_s),
      motors_(control::motors_of_file(device.description().motor)),
      safety_(device.description(), period_s) {
    for (control::ObservedMotor &motor : motors_) {
        motor.R_hat_limit_Ohm = device.description().amplifier.max_cancelled_Ohm;
    }
}

void ServoLoop::stop() noexcept {
    command_ = device::DeviceCommand::braking();
    device_.write(command_);
}

void ServoLoop::fail(const AssertionFailure &failure) noexcept {
    command_ = safety_.fail(failure);
    device_.write(command_);
    // Its sample was not published: the next tick, which brakes, reuses the number.
    tick_ = tick_begun_;
}

void ServoLoop::set_period(double period_s) {
    device_.set_period(period_s);
    // The next tick is one new period later.
    const std::uint64_t last_tick = tick_ > 0 ? tick_ - 1 : 0;
    time_base_s_ += static_cast<double>(last_tick - time_base_tick_) * period_s_;
    time_base_tick_ = last_tick;
    period_s_ = period_s;
    transfer_.set_period(period_s);
    observers_.set_timing(device_.delay_periods(), period_s);
    safety_.set_period(period_s);
}

/// Takes the inputs that apply even without a new measurement.
void ServoLoop::take_orders(const ServoInputs &inputs) noexcept {
    if (inputs.reset_count != inputs_.reset_count && safety_.reset(inputs.released_stop)) {
        observers_.restart();
    }
    if (inputs.unwatched_count != inputs_.unwatched_count) {
        safety_.resume_watch(inputs.hottest);
    }
    inputs_.unwatched_count = inputs.unwatched_count;
    inputs_.reset_count = inputs.reset_count;
    inputs_.requested_stop = inputs.requested_stop;
    inputs_.released_stop = inputs.released_stop;
    inputs_.release = inputs.release;
    inputs_.heartbeat = inputs.heartbeat;
}

void ServoLoop::take(const ServoInputs &inputs) noexcept {
    take_orders(inputs);
    const ServoInputs last = inputs_;
    inputs_ = inputs;
    if (!control::is_valid(inputs.tuning)) {
        inputs_.tuning = last.tuning;
    }
    control::Tuning with_global_alpha;
    with_global_alpha.alpha_rad2_per_m2 = inputs.global_alpha_rad2_per_m2;
    if (!control::is_valid(with_global_alpha)) {
        inputs_.global_alpha_rad2_per_m2 = last.global_alpha_rad2_per_m2;
    }
}

contact::Contact ServoLoop::touch(const Vector3 &tip_m) noexcept {
    scene_is_new_ = inputs_.scene_id != scene_id_ || inputs_.surface != surface_ ||
                    inputs_.fixed_x0_m != fixed_x0_m_;
    if (!has_measured_ || scene_is_new_) {
        scene_id_ = inputs_.scene_id;
        surface_ = inputs_.surface;
        fixed_x0_m_ = inputs_.fixed_x0_m;
        proxy_.reset(tip_m);
    }
    if (fixed_x0_m_) {
        contact::Contact held;
        held.touching = true;
        held.x0_m = *fixed_x0_m_;
        held.tangent_projector = Matrix3::Zero();
        held.eta = 0.0;
        held.active_constraints = 3;
        return held;
    }
    if (inputs_.surface == nullptr) {
        contact::Contact free;
        free.x0_m = tip_m;
        return free;
    }
    return proxy_.update(*inputs_.surface, tip_m);
}

/// The law's outcome with the previous settings; empty if none has changed or no motor is driven.
/// @param filter  its state before this tick
std::optional<control::LawOutcome>
ServoLoop::unchanged_law(control::VelocityFilter filter, double since_last_s,
                         const Vector3 &theta_rad, const contact::Contact &contact) const noexcept {
    if (!transfer_.has_changed() || scene_is_new_ || !safety_.lets_pass()) {
        return std::nullopt;
    }
    const LawSettings &before = transfer_.before();
    const double pole = control::velocity_filter_pole(before.tuning.lambda_rad_per_s, since_last_s);
    return law_(law_.configuration(theta_rad, filter.update(theta_rad, pole, since_last_s)),
                contact, before.tuning, {before.global_alpha_rad2_per_m2, alpha_before_}, motors_,
                lag_s());
}

control::LawOutcome ServoLoop::law(const control::Configuration &now,
                                   ServoSample &sample) const noexcept {
    const LawSettings &active = transfer_.active();
    sample.motor = motors_;
    sample.lag_s = lag_s();
    const control::LawOutcome found =
        law_(now, sample.contact, active.tuning, {active.global_alpha_rad2_per_m2, alpha_before_},
             motors_, sample.lag_s);
    note_law(law_, now, found, sample);
    note_rendered_error(sample);
    return found;
}

/// Static force of the coupling K_q (20) between tip and proxy, as it acts.
Vector3 ServoLoop::spring_force_N(const control::Configuration &now, const control::Tuning &tuning,
                                  const control::LawOutcome &found) const noexcept {
    return control::static_tip_force(
        now.J, found.stiffness_share.cwiseProduct(law_.static_stiffness_Nm_per_rad(tuning)),
        found.used.theta_Sd_rad - now.theta_rad);
}

/// From the measurement to θ, θ̇_f, x and J.
control::Configuration ServoLoop::sense(const device::Measurement &measured,
                                        double since_last_s) noexcept {
    const Vector3 theta_rad = law_.theta_rad(measured.counts);
    if (!has_measured_) {
        velocity_filter_.reset(theta_rad);
    }
    const double pole =
        control::velocity_filter_pole(transfer_.active().tuning.lambda_rad_per_s, since_last_s);
    return law_.configuration(theta_rad, velocity_filter_.update(theta_rad, pole, since_last_s));
}

void ServoLoop::observe_motors(const device::Measurement &measured, const Vector3 &theta_rad,
                               const Passed &since) noexcept {
    constexpr double kOnTime = 0.05; // of a period
    const bool is_next = has_measured_ && held_ticks_ == 0 && since.missed_periods == 0 &&
                         std::abs(since.since_last_s - period_s_) < kOnTime * period_s_ &&
                         measured.arrival == device::Arrival::fresh && measured.has_new_command &&
                         measured.current_A.allFinite();
    // Of a motor that is not observed dR may be far less than the limit leaves of the file's R:
    // then larger gains would be no remedy, and the law is not told.
    Vector3 R_hat_limit_Ohm(safety_.windings()[0].R_hat_limit_Ohm,
                            safety_.windings()[1].R_hat_limit_Ohm,
                            safety_.windings()[2].R_hat_limit_Ohm);
    // With two sensors for a current, the amplifier's has an offset of its own, which is not known.
    if (!inputs_.observes_resistance || !device_.description().current_sensing.is_shared) {
        if (motors_.front().is_observed) {
            observers_.restart();
        }
        observers_.rest(measured, theta_rad, is_next, since.missed_periods);
        R_hat_limit_Ohm = Vector3::Constant(device_.description().amplifier.max_cancelled_Ohm);
    } else {
        for (std::size_t j = 0; j < motors_.size(); ++j) {
            if (motors_[j].is_trusted && safety_.windings()[j].is_contradicted) {
                observers_.distrust(j);
            }
        }
        observers_.update(measured, theta_rad, is_next, since.missed_periods);
    }
    const double step_Ohm = max_resistance_change_Ohm_per_s(device_.description()) * period_s_;
    const control::ObservedMotors before = std::exchange(motors_, observers_.motors());
    held_force_.update(control::without_offsets(measured.current_A, motors_), since.since_last_s);
    for (std::size_t j = 0; j < motors_.size(); ++j) {
        const auto i = static_cast<Eigen::Index>(j);
        motors_[j].load = held_force_.load(i);
        motors_[j].R_hat_limit_Ohm =
            std::clamp(R_hat_limit_Ohm[i], before[j].R_hat_limit_Ohm - step_Ohm,
                       before[j].R_hat_limit_Ohm + step_Ohm);
        // A fixed set-point is there to measure the drive.
        if (!safety_.lets_pass() || inputs_.fixed_x0_m) {
            motors_[j].trim_V = 0.0;
        } else if (const std::optional<control::DrivenInterval> &driven = observers_.interval(j)) {
            motors_[j].trim_V =
                control::next_trim_V(device_.description().motor[j], motors_[j], *driven,
                                     trim_V_[i], spring_A_[i], held_force_.is_held());
        } else {
            motors_[j].trim_V = trim_V_[i];
        }
    }
}

void ServoLoop::note_motion(const control::Configuration &now, ServoSample &sample) const noexcept {
    sample.theta_rad = now.theta_rad;
    sample.theta_rate_rad_per_s = now.theta_rate_rad_per_s;
    sample.tip_m = now.tip_m;
    sample.tip_force_N =
        control::static_tip_force(now.J, control::torque_constants(motors_),
                                  control::without_offsets(sample.current_A, motors_));
}

/// The monitor's inputs.
Observation ServoLoop::observation(const control::Configuration &now,
                                   const control::LawOutcome &found,
                                   const std::optional<control::LawOutcome> &unchanged,
                                   const Passed &since, const device::Measurement &measured,
                                   const ServoSample &sample) const noexcept {
    Observation seen;
    seen.now = now;
    seen.link = {measured.health, measured.arrival, measured.faults, since.missed_in_a_row,
                 measured.zeroing};
    seen.tip_force_N = sample.tip_force_N;
    seen.current_A = measured.current_A;
    seen.touching = sample.contact.touching;
    if (sample.contact.touching) {
        seen.spring_stretch_m = sample.contact.x0_m - now.tip_m;
        seen.spring_force_N = spring_force_N(now, transfer_.active().tuning, found);
        seen.spring_force_before_N =
            unchanged ? spring_force_N(now, transfer_.before().tuning, *unchanged)
                      : seen.spring_force_N;
    }
    seen.motors = motors_;
    seen.trim_V = found.trim_V;
    for (std::size_t j = 0; j < seen.unheated.size(); ++j) {
        seen.unheated[j] = observers_.unheated(j);
        seen.interval[j] = observers_.interval(j);
    }
    seen.has_inductance = inputs_.has_inductance;
    seen.scene_is_new = scene_is_new_;
    seen.all_finite = sample.contact.x0_m.allFinite();
    seen.missed_periods = since.missed_periods;
    return seen;
}

SafetyOrders ServoLoop::orders() const noexcept {
    return {inputs_.limits, inputs_.requested_stop, inputs_.released_stop, inputs_.heartbeat,
            inputs_.release};
}

/// Time since the last measurement: by measurement numbers on the servo's clock, else by the
/// device's own clock.
ServoLoop::Passed ServoLoop::passed(const device::Measurement &measured,
                                    const TickTiming &timing) noexcept {
    const bool waits = device_.clock() == device::DeviceClock::servo;
    if (!has_measured_) {
        return {period_s_, 0, waits ? 0 : timing.missed_in_a_row};
    }
    if (!waits) {
        const double since_s = measured.time_s - measured_.time_s;
        const double since_last_s = since_s > 0.0 ? since_s : period_s_;
        if (!(since_s > 0.0)) {
            safety_.resume_watch({}); // by another clock
        }
        const double missed = std::round(since_last_s / period_s_) - 1.0;
        return {since_last_s,
                static_cast<std::uint32_t>(std::clamp(missed, 0.0, kMaxMissedPeriods)),
                timing.missed_in_a_row};
    }
    const std::uint64_t periods =
        measured.number > measured_.number ? measured.number - measured_.number : 1;
    const auto missed = static_cast<std::uint32_t>(
        std::min(periods - 1, static_cast<std::uint64_t>(kMaxMissedPeriods)));
    const std::uint32_t skipped =
        std::exchange(expects_gap_, false) ? 0 : missed - std::min(missed, held_ticks_);
    skipped_in_a_row_ = skipped > 0 ? skipped_in_a_row_ + skipped : 0;
    return {(1.0 + missed) * period_s_, missed, skipped_in_a_row_};
}

ServoSample ServoLoop::begin_sample(const device::Measurement &measured,
                                    const TickTiming &timing) const noexcept {
    ServoSample sample;
    sample.tick = tick_;
    sample.time_s = time_base_s_ + static_cast<double>(tick_ - time_base_tick_) * period_s_;
    sample.measurement_number = measured.number;
    sample.measured_s = measured.time_s;
    sample.arrival = measured.arrival;
    sample.health = measured.health;
    sample.board_faults = measured.faults.bits;
    sample.supply_V = measured.supply_V;
    sample.missed_deadlines = timing.missed_deadlines;
    sample.missed_in_a_row = timing.missed_in_a_row;
    sample.tuning = transfer_.active().tuning;
    sample.global_alpha_rad2_per_m2 = transfer_.active().global_alpha_rad2_per_m2;
    return sample;
}

/// Completes the sample with the active command and the monitor's state.
void ServoLoop::finish(const device::Measurement &measured, ServoSample &sample) noexcept {
    alpha_before_ = alpha_in_contact(sample.contact, sample.alpha_rad2_per_m2);
    command_.number = measured.number;
    sample.command = command_;
    sample.safety = safety_.status();
    sample.active_limits = safety_.active_limits();
    sample.limits = safety_.limits();
    sample.generated_energy_J = safety_.generated_energy_J();
    sample.winding = safety_.windings();
    ++tick_;
}

/// A tick without a new measurement: keeps the state of the last one.
ServoSample ServoLoop::hold(const device::Measurement &measured, const ServoInputs &inputs,
                            const TickTiming &timing) noexcept {
    take_orders(inputs);
    ServoSample sample = begin_sample(measured, timing);
    sample.scene_id = scene_id_;
    sample.counts = measured_.counts;
    sample.current_A = measured_.current_A;
    sample.transfer_offset_V = transfer_.transfer_offset_V();
    if (has_measured_) {
        const control::Configuration then =
            law_.configuration(velocity_filter_.theta_rad(), velocity_filter_.velocity_rad_per_s());
        note_motion(then, sample);
        sample.contact = contact_;
        static_cast<void>(law(then, sample));
    }
    ++held_ticks_;
    observers_.skip();
    if (measured.health == device::DeviceHealth::lost) {
        observers_.forget_zero();
    }
    const bool waits = device_.clock() == device::DeviceClock::servo;
    const Link link{measured.health, measured.arrival, measured.faults,
                    waits ? skipped_in_a_row_ : timing.missed_in_a_row, measured.zeroing};
    command_ = safety_.hold(command_, link, orders());
    finish(measured, sample);
    return sample;
}

/// A tick after a failed assertion: only what the window needs to show the device.
ServoSample ServoLoop::brake(const device::Measurement &measured, const ServoInputs &inputs,
                             const TickTiming &timing) noexcept {
    scene_id_ = inputs.scene_id; // no scene is in use
    ServoSample sample = begin_sample(measured, timing);
    sample.scene_id = scene_id_;
    sample.counts = measured.counts;
    sample.current_A = measured.current_A;
    note_motion(law_.configuration(law_.theta_rad(measured.counts), Vector3::Zero()), sample);
    sample.motor = motors_;
    sample.contact.x0_m = sample.x_Sd_m = sample.tip_m;
    sample.theta_Sd_rad = sample.theta_rad;
    sample.rendered_error_rad = sample.inverse_error_rad = sample.transpose_error_rad = kNone;
    finish(measured, sample);
    return sample;
}

ServoSample ServoLoop::update(const device::Measurement &measured, const ServoInputs &inputs,
                              const TickTiming &timing) noexcept {
    if (is_final(safety_.status().cause)) {
        return brake(measured, inputs, timing);
    }
    if (!device::is_new(measured.arrival) || measured.health == device::DeviceHealth::lost) {
        return hold(measured, inputs, timing);
    }
    take(inputs);
    transfer_.approach({inputs_.tuning, inputs_.global_alpha_rad2_per_m2}, safety_.lets_pass());

    const Passed since = passed(measured, timing);
    ServoSample sample = begin_sample(measured, timing);
    sample.since_last_s = since.since_last_s;
    sample.missed_periods = since.missed_periods;
    sample.counts = measured.counts;
    sample.current_A = measured.current_A;

    const control::VelocityFilter filter_before = velocity_filter_;
    const control::Configuration now = sense(measured, since.since_last_s);
    if (measured.zeroing != measured_.zeroing) {
        observers_.restart(); // what they know of other angles
    }
    observe_motors(measured, now.theta_rad, since);
    note_motion(now, sample);
    sample.contact = touch(now.tip_m);
    sample.scene_id = scene_id_;
    const control::LawOutcome found = law(now, sample);
    spring_A_ = found.spring_A;
    trim_V_ = found.trim_V.cwiseProduct(found.spring_A.cwiseSign());
    const std::optional<control::LawOutcome> unchanged =
        unchanged_law(filter_before, since.since_last_s, now.theta_rad, sample.contact);

    transfer_.carry(found.command.e_W_V,
                    unchanged ? std::optional(unchanged->command.e_W_V) : std::nullopt,
                    scene_is_new_, safety_.lets_pass());
    sample.transfer_offset_V = transfer_.transfer_offset_V() + inputs_.excitation_V;
    device::DeviceCommand requested = found.command;
    requested.e_W_V += sample.transfer_offset_V;
    command_ = safety_.pass(requested, observation(now, found, unchanged, since, measured, sample),
                            orders());
    observers_.record(command_);

    measured_ = measured;
    contact_ = sample.contact;
    has_measured_ = true;
    held_ticks_ = 0;
    finish(measured, sample);
    return sample;
}

} // namespace springdrive::servo
