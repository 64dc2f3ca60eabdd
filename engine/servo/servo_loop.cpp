#include "engine/servo/servo_loop.h"

#include "engine/contact/proxy/haptic_surface.h"
#include "engine/control/force_direction.h"
#include "engine/control/parameters.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>

namespace springdrive::servo {

namespace {

/// Below this a rendered force has no direction worth telling: it is of the size that single
/// encoder counts make of the velocity signal.
constexpr double kLeastForceWithDirection_N = 0.1;

/// A parameter glides to its new value with this time constant, and is there when it is within this
/// share of its range.
constexpr double kTuningGlide_s = 0.05;
constexpr double kTuningArrived = 1e-6;

/// Below this a set-point is where the tip is, and the rest is round-off: at η = 1, say.
constexpr double kLeastSetPointGap_m = 1e-6;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// A device's clock may leap; no count of periods does more than this.
constexpr double kMostMissedPeriods = 1e6;

/// A failed assertion leaves a tick without destructors, see `run_guarded`: there must be none.
static_assert(std::is_trivially_destructible_v<ServoSample> &&
              std::is_trivially_destructible_v<Observation> &&
              std::is_trivially_destructible_v<LimitedCommand> &&
              std::is_trivially_destructible_v<control::LawOutcome> &&
              std::is_trivially_destructible_v<contact::Proxy>);

/// R̂ i too is a voltage: it moves no faster than a change may, whatever current a winding bears.
double greatest_dR_step_Ohm(const device::DeviceDescription &device, double period_s) {
    double peak_A = 0.0;
    for (const device::MotorParameters &motor : device.motor) {
        peak_A = std::max(peak_A, motor.peak_current_A);
    }
    return kGreatestChange_V_per_s * period_s / peak_A;
}

} // namespace

ServoLoop::ServoLoop(device::HapticDevice &device, double period_s)
    : device_(device), period_s_(period_s), law_(device.description()),
      supply_V_(device.description().motor[0].supply_V, device.description().motor[1].supply_V,
                device.description().motor[2].supply_V),
      greatest_dR_step_Ohm_(greatest_dR_step_Ohm(device.description(), period_s)),
      change_over_(period_s), safety_(device.description(), period_s) {}

void ServoLoop::stop() noexcept {
    command_ = device::DeviceCommand::braking();
    device_.write(command_);
}

void ServoLoop::fail(const AssertionFailure &failure) noexcept {
    command_ = safety_.fail(failure);
    device_.write(command_);
    tick_ = tick_begun_; // nobody has its sample: the next one, which brakes, takes its place
}

void ServoLoop::set_period(double period_s) {
    device_.set_period(period_s);
    const std::uint64_t last_tick = tick_ > 0 ? tick_ - 1 : 0; // the next is the new period later
    time_base_s_ += static_cast<double>(last_tick - time_base_tick_) * period_s_;
    time_base_tick_ = last_tick;
    period_s_ = period_s;
    greatest_dR_step_Ohm_ = greatest_dR_step_Ohm(device_.description(), period_s);
    change_over_.set_period(period_s);
    safety_.set_period(period_s);
}

/// What does not wait for a measurement.
void ServoLoop::take_orders(const ServoInputs &inputs) noexcept {
    if (inputs.reset_count != inputs_.reset_count) {
        safety_.reset();
    }
    stops_now_ = inputs.stop_count != inputs_.stop_count;
    inputs_.reset_count = inputs.reset_count;
    inputs_.stop_count = inputs.stop_count;
    inputs_.emergency_stop = inputs.emergency_stop;
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

void ServoLoop::approach(const control::Tuning &wanted) noexcept {
    if (!has_measured_ || !safety_.lets_pass()) {
        tuning_ = wanted; // nobody feels it
        return;
    }
    const double share = -std::expm1(-period_s_ / kTuningGlide_s);
    tuning_.map = wanted.map;
    tuning_.alpha_mode = wanted.alpha_mode;
    const double dR_before_Ohm = tuning_.dR_Ohm;
    for (const control::Parameter &parameter : control::kParameters) {
        double &value = tuning_.*parameter.value;
        const double gap = wanted.*parameter.value - value;
        const bool arrived =
            std::abs(gap) < kTuningArrived * (parameter.highest - parameter.lowest);
        value = arrived ? wanted.*parameter.value : value + share * gap;
    }
    tuning_.dR_Ohm = std::clamp(tuning_.dR_Ohm, dR_before_Ohm - greatest_dR_step_Ohm_,
                                dR_before_Ohm + greatest_dR_step_Ohm_);
}

bool ServoLoop::in_force(const Before &before) const noexcept {
    return before.tuning == tuning_ &&
           before.global_alpha_rad2_per_m2 == inputs_.global_alpha_rad2_per_m2;
}

/// What the filter would say with that cutoff; it remembers only what `update` settles on.
control::Configuration ServoLoop::configuration(const Vector3 &theta_rad,
                                                double lambda_rad_per_s) const noexcept {
    control::VelocityFilter filter = velocity_filter_;
    const double pole = control::velocity_filter_pole(lambda_rad_per_s, since_last_s_);
    return law_.configuration(theta_rad, filter.update(theta_rad, pole, since_last_s_));
}

contact::Contact ServoLoop::touch(const Vector3 &tip_m) noexcept {
    scene_is_new_ = inputs_.scene_id != scene_id_ || inputs_.surface != surface_;
    if (!has_measured_ || scene_is_new_) {
        scene_id_ = inputs_.scene_id;
        surface_ = inputs_.surface;
        proxy_.reset(tip_m);
    }
    if (inputs_.surface == nullptr) {
        contact::Contact free;
        free.x0_m = tip_m;
        return free;
    }
    return proxy_.update(*inputs_.surface, tip_m);
}

Vector3 ServoLoop::within_supply(const Vector3 &e_W_V) const noexcept {
    return e_W_V.cwiseMax(-supply_V_).cwiseMin(supply_V_);
}

/// What the law would say if nothing had changed; nothing where nothing has, or nobody feels it.
std::optional<control::LawOutcome>
ServoLoop::unchanged_law(const Before &before, const Vector3 &theta_rad,
                         const contact::Contact &contact) const noexcept {
    if (in_force(before) || scene_is_new_ || !safety_.lets_pass()) {
        return std::nullopt;
    }
    return law_(configuration(theta_rad, before.tuning.lambda_rad_per_s), contact, before.tuning,
                before.global_alpha_rad2_per_m2);
}

/// Lets no change of this tick move e_W at once, as long as anybody feels it.
void ServoLoop::carry_over(const std::optional<control::LawOutcome> &unchanged,
                           const Vector3 &e_W_V) noexcept {
    if (!safety_.lets_pass()) {
        change_over_.reset();
        return;
    }
    if (scene_is_new_) { // the old one's contact is not known any more: what it last asked for is
        change_over_.reset();
        change_over_.change(last_e_W_V_, e_W_V);
    } else if (unchanged) {
        // No more than the supply would have given; of what is wanted now, all there is to let in.
        const Vector3 without_V =
            within_supply(unchanged->command.e_W_V + change_over_.carried_V());
        change_over_.reset();
        change_over_.change(without_V, e_W_V);
    }
    change_over_.fade();
}

control::LawOutcome ServoLoop::law(const control::Configuration &now,
                                   ServoSample &sample) const noexcept {
    const contact::Contact &contact = sample.contact;
    const control::LawOutcome found = law_(now, contact, tuning_, inputs_.global_alpha_rad2_per_m2);
    sample.eta = found.eta;
    sample.alpha_rad2_per_m2 = found.alpha_rad2_per_m2;
    sample.alpha_bound_rad2_per_m2 = found.alpha_bound_rad2_per_m2;
    sample.inverse_possible = found.inverse.has_value();
    sample.x_Sd_m = found.x_Sd_m;
    sample.theta_Sd_rad = found.used.theta_Sd_rad;

    const bool pushes = contact.touching && (found.x_Sd_m - now.tip_m).norm() > kLeastSetPointGap_m;
    const auto static_error = [&](const control::MotorSetPoint &set_point) {
        return control::direction_error_rad(law_.force_direction(now, set_point), contact.normal);
    };
    sample.inverse_error_rad = pushes && found.inverse ? static_error(*found.inverse) : kNone;
    sample.transpose_error_rad = pushes ? static_error(found.transpose) : kNone;
    sample.rendered_error_rad =
        contact.touching && sample.tip_force_N.norm() > kLeastForceWithDirection_N
            ? control::direction_error_rad(sample.tip_force_N, contact.normal)
            : kNone;
    return found;
}

/// Static force of the coupling K_DC (13) between tip and proxy.
Vector3 ServoLoop::spring_force_N(const control::Configuration &now, const control::Tuning &tuning,
                                  const control::MotorSetPoint &set_point) const noexcept {
    return control::static_tip_force(now.J, law_.static_stiffness_Nm_per_rad(tuning),
                                     set_point.theta_Sd_rad - now.theta_rad);
}

/// From the measurement to θ, θ̇_f, x and J.
control::Configuration ServoLoop::sense(const device::Measurement &measured,
                                        ServoSample &sample) noexcept {
    const Vector3 theta_rad = law_.theta_rad(measured.counts);
    if (!has_measured_) {
        velocity_filter_.reset(theta_rad);
    }
    const control::Configuration now = configuration(theta_rad, tuning_.lambda_rad_per_s);
    note_motion(now, sample);
    return now;
}

void ServoLoop::note_motion(const control::Configuration &now, ServoSample &sample) const noexcept {
    sample.theta_rad = now.theta_rad;
    sample.theta_rate_rad_per_s = now.theta_rate_rad_per_s;
    sample.tip_m = now.tip_m;
    sample.tip_force_N = control::static_tip_force(now.J, law_.k_T(), sample.current_A);
}

/// From what the law wants to what the device gets.
void ServoLoop::guard(device::DeviceCommand wanted, const Observation &seen, bool inputs_are_whole,
                      ServoSample &sample) noexcept {
    wanted.e_W_V += sample.carried_V;
    last_e_W_V_ = within_supply(wanted.e_W_V);
    command_ = safety_.pass(wanted, seen, orders(inputs_are_whole));
}

SafetyOrders ServoLoop::orders(bool inputs_are_whole) const noexcept {
    return {inputs_.limits, inputs_.emergency_stop || stops_now_, inputs_.heartbeat,
            inputs_are_whole, inputs_.release};
}

/// By the device's clock: numbers where it keeps the servo's, else its own time.
ServoLoop::Passed ServoLoop::passed(const device::Measurement &measured,
                                    const TickTiming &timing) noexcept {
    const bool waits = device_.clock() == device::DeviceClock::servo;
    if (!has_measured_) {
        return {period_s_, 0, waits ? 0 : timing.missed_in_a_row};
    }
    if (!waits) {
        const double since_s = measured.time_s - measured_.time_s;
        const double since_last_s = since_s > 0.0 ? since_s : period_s_;
        const double missed = std::round(since_last_s / period_s_) - 1.0;
        return {since_last_s,
                static_cast<std::uint32_t>(std::clamp(missed, 0.0, kMostMissedPeriods)),
                timing.missed_in_a_row};
    }
    const std::uint64_t periods =
        measured.number > measured_.number ? measured.number - measured_.number : 1;
    const auto missed = static_cast<std::uint32_t>(
        std::min(periods - 1, static_cast<std::uint64_t>(kMostMissedPeriods)));
    const std::uint32_t skipped = missed - std::min(missed, held_ticks_);
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
    sample.tuning = tuning_;
    sample.global_alpha_rad2_per_m2 = inputs_.global_alpha_rad2_per_m2;
    return sample;
}

/// What is in force at the end of a tick.
void ServoLoop::finish(const device::Measurement &measured, ServoSample &sample) noexcept {
    command_.number = measured.number;
    sample.command = command_;
    sample.safety = safety_.status();
    sample.held_back = safety_.held_back();
    sample.limits = safety_.limits();
    sample.generated_energy_J = safety_.generated_energy_J();
    sample.winding = safety_.windings();
    ++tick_;
}

/// A tick without news: all stands as it was when there last were some.
ServoSample ServoLoop::hold(const device::Measurement &measured, const ServoInputs &inputs,
                            const TickTiming &timing) noexcept {
    const bool whole = is_whole(inputs);
    if (whole) {
        take_orders(inputs);
    }
    ServoSample sample = begin_sample(measured, timing);
    sample.scene_id = scene_id_;
    sample.counts = measured_.counts;
    sample.current_A = measured_.current_A;
    sample.carried_V = change_over_.carried_V();
    if (has_measured_) {
        const control::Configuration then =
            law_.configuration(velocity_filter_.theta_rad(), velocity_filter_.velocity_rad_per_s());
        note_motion(then, sample);
        sample.contact = contact_;
        static_cast<void>(law(then, sample));
    }
    ++held_ticks_;
    const bool waits = device_.clock() == device::DeviceClock::servo;
    const Link link{measured.health, measured.arrival, measured.faults,
                    waits ? skipped_in_a_row_ : timing.missed_in_a_row};
    command_ = safety_.hold(command_, link, orders(whole));
    finish(measured, sample);
    return sample;
}

/// A tick after an assertion has failed, with as little as a window needs to show the device.
ServoSample ServoLoop::brake(const device::Measurement &measured, const ServoInputs &inputs,
                             const TickTiming &timing) noexcept {
    if (is_whole(inputs)) {
        scene_id_ = inputs.scene_id; // nothing of any scene is in use
    }
    ServoSample sample = begin_sample(measured, timing);
    sample.scene_id = scene_id_;
    sample.counts = measured.counts;
    sample.current_A = measured.current_A;
    note_motion(law_.configuration(law_.theta_rad(measured.counts), Vector3::Zero()), sample);
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
    stops_now_ = false;
    if (!device::has_news(measured.arrival) || measured.health == device::DeviceHealth::lost) {
        return hold(measured, inputs, timing);
    }
    const Before before{tuning_, inputs_.global_alpha_rad2_per_m2};
    const bool whole = is_whole(inputs);
    if (whole) {
        take(inputs);
    }
    approach(inputs_.tuning);

    const Passed since = passed(measured, timing);
    since_last_s_ = since.since_last_s;
    ServoSample sample = begin_sample(measured, timing);
    sample.since_last_s = since.since_last_s;
    sample.missed_periods = since.missed_periods;
    sample.counts = measured.counts;
    sample.current_A = measured.current_A;

    Observation seen;
    seen.now = sense(measured, sample);
    sample.contact = touch(seen.now.tip_m);
    sample.scene_id = scene_id_;
    const control::LawOutcome found = law(seen.now, sample);
    const std::optional<control::LawOutcome> unchanged =
        unchanged_law(before, seen.now.theta_rad, sample.contact);
    carry_over(unchanged, found.command.e_W_V);
    velocity_filter_ = control::VelocityFilter(seen.now.theta_rad, seen.now.theta_rate_rad_per_s);
    sample.carried_V = change_over_.carried_V();

    seen.link = {measured.health, measured.arrival, measured.faults, since.missed_in_a_row};
    seen.tip_force_N = sample.tip_force_N;
    seen.current_A = measured.current_A;
    seen.touching = sample.contact.touching;
    if (sample.contact.touching) {
        seen.spring_stretch_m = sample.contact.x0_m - seen.now.tip_m;
        seen.spring_force_N = spring_force_N(seen.now, tuning_, found.used);
        seen.spring_force_before_N = unchanged
                                         ? spring_force_N(seen.now, before.tuning, unchanged->used)
                                         : seen.spring_force_N;
    }
    seen.scene_is_new = scene_is_new_;
    seen.all_finite = sample.contact.x0_m.allFinite();
    seen.missed_periods = since.missed_periods;
    guard(found.command, seen, whole, sample);

    measured_ = measured;
    contact_ = sample.contact;
    has_measured_ = true;
    held_ticks_ = 0;
    finish(measured, sample);
    return sample;
}

} // namespace springdrive::servo
