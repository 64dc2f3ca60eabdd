#include "engine/study/stimuli/stimulus.h"

#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"
#include "engine/servo/bumpless_transfer.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace springdrive::study {

ForceAngles force_angles(const TurnFrame &frame, const Vector3 &force) {
    const Vector3 towards = frame.turn_axis.cross(frame.normal);
    const double along = force.dot(frame.normal);
    const double turned = force.dot(towards);
    return {kDegreesPerRadian * std::atan2(turned, along),
            kDegreesPerRadian * std::atan2(force.dot(frame.turn_axis), std::hypot(turned, along))};
}

double Pulse::force_N(double since_s) const noexcept {
    const double phase = since_s * frequency_hz;
    return phase < 0.0 || phase > 1.0
               ? 0.0
               : 0.5 * height_N * (1.0 - std::cos(2.0 * std::numbers::pi * phase));
}

double Pulse::rate_N_per_s(double since_s) const noexcept {
    const double phase = since_s * frequency_hz;
    return phase < 0.0 || phase > 1.0 ? 0.0
                                      : std::numbers::pi * frequency_hz * height_N *
                                            std::sin(2.0 * std::numbers::pi * phase);
}

double Stimulus::pulse_from_s() const {
    return std::max(
        0.0, std::min(0.5 * presentation_s, presentation_s - pulse.length_s() - kAfterPulse_s));
}

double glide_back_s(const Stimulus &stimulus) {
    constexpr double kTunings_s = 0.5;
    constexpr double kSteering_s = 0.25;
    const bool glides = stimulus.contact.dR_Ohm != stimulus.free_space.dR_Ohm ||
                        stimulus.contact.lambda_rad_per_s != stimulus.free_space.lambda_rad_per_s;
    if (stimulus.form == StimulusForm::stroke) {
        return 0.0;
    }
    return std::max(stimulus.min_glide_back_s, glides                ? kTunings_s
                                               : stimulus.is_steered ? kSteering_s
                                                                     : 0.0);
}

namespace {

constexpr double kSpeedTime_s = 0.01;

double clock_of(const servo::ServoSample &sample) {
    return std::isnan(sample.clock_s) ? sample.time_s : sample.clock_s;
}

} // namespace

ForceSteering::ForceSteering(const Vector3 &normal, const Vector3 &direction, Pace pace,
                             double max_work_J, double max_force_N, double period_s)
    : normal_(normal), slope_(direction / direction.dot(normal) - normal),
      is_prompt_(pace == Pace::prompt), max_work_J_(max_work_J), max_force_N_(max_force_N),
      gap_share_(-std::expm1(-period_s / kTime_s)) {}

void ForceSteering::count(const Vector3 &tip_m, const Vector3 &force_N) noexcept {
    const Vector3 along_N = force_N - force_N.dot(normal_) * normal_;
    if (has_last_) {
        work_J_ += 0.5 * (along_N + last_force_N_).dot(tip_m - last_tip_m_);
        has_given_up_ = has_given_up_ || work_J_ > max_work_J_;
    }
    has_last_ = true;
    last_tip_m_ = tip_m;
    last_force_N_ = along_N;
}

Vector3 ForceSteering::update(const Vector3 &tip_m, const Vector3 &force_N, double share) noexcept {
    count(tip_m, force_N);
    const double pressed_N = std::max(0.0, force_N.dot(normal_));
    const Vector3 target_N =
        has_given_up_ ? Vector3(Vector3::Zero()) : Vector3(share * pressed_N * slope_);
    integral_N_ += gap_share_ * (target_N - last_force_N_);
    const Vector3 at_once_N = is_prompt_ ? target_N : Vector3(Vector3::Zero());
    const Vector3 added_N = at_once_N + integral_N_;
    const double size_N = added_N.norm();
    if (size_N > max_force_N_) {
        integral_N_ = added_N * (max_force_N_ / size_N) - at_once_N;
        return added_N * (max_force_N_ / size_N);
    }
    return added_N;
}

StimulusRun::StimulusRun(const device::DeviceDescription &device, const Stimulus &stimulus,
                         double period_s)
    : device_(device), stimulus_(stimulus), period_s_(period_s), rest_(period_s),
      steering_(stimulus.frame.normal, stimulus.direction,
                stimulus.form == StimulusForm::blow ? ForceSteering::Pace::prompt
                                                    : ForceSteering::Pace::slow,
                kWorkShare * device.limits.generated_energy_J,
                kMaxAdded * device.limits.tip_force_N, period_s) {}

void StimulusRun::enter(StimulusPhase phase) noexcept {
    phase_ = phase;
    in_phase_s_ = 0.0;
}

void StimulusRun::fail(StimulusFailure failure) noexcept {
    failure_ = failure;
    enter(StimulusPhase::failed);
}

void StimulusRun::wait(const servo::ServoSample &last) noexcept {
    const bool is_near = (last.tip_m - stimulus_.start_m).norm() <= kNearStart_m;
    const bool is_running = last.safety.state == servo::SafetyState::running;
    rested_s_ = is_near && is_running && rest_.is_at_rest() ? rested_s_ + period_s_ : 0.0;
    if (rested_s_ + servo::RestDetector::kTime_s < stimulus_.rest_s) {
        return;
    }
    if (stimulus_.form == StimulusForm::stroke) {
        presented_s_ = 0.0;
        enter(StimulusPhase::presenting);
    } else {
        enter(StimulusPhase::approaching);
    }
}

void StimulusRun::approach(const servo::ServoSample &last) noexcept {
    if (!last.contact.touching) {
        if (in_phase_s_ > stimulus_.approach_s) {
            fail(StimulusFailure::never_touched);
        }
        return;
    }
    presented_s_ = 0.0;
    alpha_at_touch_rad2_per_m2_ = last.alpha_bound_rad2_per_m2;
    if (stimulus_.hold == Hold::cup) {
        cup_m_ = last.contact.x0_m;
    }
    enter(StimulusPhase::presenting);
}

/// A hand that is to press or to rest must not leave; one that strikes may.
void StimulusRun::watch_contact(const servo::ServoSample &last) noexcept {
    lost_s_ = last.contact.touching ? 0.0 : lost_s_ + period_s_;
    const bool is_out_of_cup =
        cup_m_ && (last.tip_m - last.contact.x0_m).dot(stimulus_.frame.normal) > kOutOfCup_m;
    const bool may_leave =
        stimulus_.form == StimulusForm::blow || stimulus_.form == StimulusForm::stroke;
    if (steering_.has_given_up()) {
        fail(StimulusFailure::too_much_work);
    } else if (!may_leave && (is_out_of_cup || lost_s_ > kBounce_s)) {
        fail(StimulusFailure::left_early);
    }
}

void StimulusRun::present(const servo::ServoSample &last) noexcept {
    watch_contact(last);
    if (phase_ == StimulusPhase::presenting && presented_s_ >= stimulus_.presentation_s) {
        enter(stimulus_.form == StimulusForm::stroke ? StimulusPhase::done
                                                     : StimulusPhase::gliding_back);
    }
}

void StimulusRun::glide_back() noexcept {
    if (in_phase_s_ >= glide_back_s(stimulus_)) {
        enter(StimulusPhase::leaving);
    }
}

void StimulusRun::leave(const servo::ServoSample &last) noexcept {
    // x₀ of the cup was given up in the tick after the last.
    if (!last.contact.touching && in_phase_s_ > 0.0) {
        enter(StimulusPhase::done);
    }
}

control::Tuning StimulusRun::tuning(const servo::ServoSample &last) const noexcept {
    const bool is_own = phase_ == StimulusPhase::presenting && last.contact.touching &&
                        stimulus_.form != StimulusForm::stroke;
    control::Tuning tuning = is_own ? stimulus_.contact : stimulus_.free_space;
    if (stimulus_.hold == Hold::cup && tuning.alpha_mode == control::AlphaMode::on_the_fly) {
        // By hand it glides: so it is where it shall be already before the touch.
        tuning.alpha_rad2_per_m2 =
            cup_m_ ? alpha_at_touch_rad2_per_m2_ : last.alpha_bound_rad2_per_m2;
        tuning.alpha_mode = cup_m_ ? control::AlphaMode::by_hand : control::AlphaMode::on_the_fly;
    }
    return tuning;
}

/// Of the turn: all of it, and on the way back evenly less.
double StimulusRun::turn_share() const noexcept {
    return phase_ == StimulusPhase::presenting
               ? 1.0
               : std::max(0.0, 1.0 - in_phase_s_ / glide_back_s(stimulus_));
}

/// Of the currents that push with the pulse and with what the steering adds.
Vector3 StimulusRun::voltage_V(const servo::ServoSample &last) noexcept {
    const bool is_presenting = phase_ == StimulusPhase::presenting;
    if (!is_presenting && phase_ != StimulusPhase::gliding_back) {
        const Vector3 bound_V = Vector3::Constant(servo::kMaxChange_V_per_s * period_s_);
        return added_V_ - added_V_.cwiseMax(-bound_V).cwiseMin(bound_V);
    }
    Vector3 force_N = Vector3::Zero();
    Vector3 rate_N_per_s = Vector3::Zero();
    if (stimulus_.is_steered) {
        force_N = steering_.update(last.tip_m, last.tip_force_N, turn_share());
    }
    if (stimulus_.form == StimulusForm::pulse && is_presenting) {
        // The command acts over the period after the next measurement.
        const double since_s = presented_s_ + 0.5 * period_s_ - stimulus_.pulse_from_s();
        force_N += stimulus_.pulse.force_N(since_s) * stimulus_.direction;
        rate_N_per_s = stimulus_.pulse.rate_N_per_s(since_s) * stimulus_.direction;
    }
    const Matrix3 J = device::motor_jacobian(
        device_.geometry, device::joint_from_motor(device_.geometry, last.theta_rad));
    const Vector3 torque_Nm = J.transpose() * force_N;
    const Vector3 torque_rate_Nm_per_s = J.transpose() * rate_N_per_s;
    Vector3 voltage_V;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const control::ObservedMotor &motor = last.motor[static_cast<std::size_t>(j)];
        const double dR_Ohm = motor.here.resistance_Ohm - last.command.cancelled_resistance_Ohm[j];
        voltage_V[j] =
            (dR_Ohm * torque_Nm[j] +
             device_.motor[static_cast<std::size_t>(j)].inductance_H * torque_rate_Nm_per_s[j]) /
            motor.torque_constant_Nm_per_A;
    }
    return voltage_V;
}

void StimulusRun::update(const servo::ServoSample &last, servo::LawInputs &inputs) noexcept {
    rest_.update(last.tip_m, last.contact.touching);
    in_phase_s_ += period_s_;
    if (presented_s_ >= 0.0) {
        presented_s_ += period_s_;
    }
    if (!is_over() && last.safety.state == servo::SafetyState::tripped) {
        fail(StimulusFailure::tripped);
    }
    switch (phase_) {
    case StimulusPhase::waiting:
        wait(last);
        break;
    case StimulusPhase::approaching:
        approach(last);
        break;
    case StimulusPhase::presenting:
        present(last);
        break;
    case StimulusPhase::gliding_back:
        watch_contact(last);
        if (phase_ == StimulusPhase::gliding_back) {
            glide_back();
        }
        break;
    case StimulusPhase::leaving:
        leave(last);
        break;
    case StimulusPhase::done:
    case StimulusPhase::failed:
        break;
    }
    if (phase_ != StimulusPhase::presenting && phase_ != StimulusPhase::gliding_back) {
        cup_m_.reset();
    }
    inputs.fixed_x0_m = cup_m_;
    inputs.tuning = tuning(last);
    added_V_ = voltage_V(last);
    inputs.excitation_V = added_V_;
}

DeliveryMeter::Window DeliveryMeter::settled(const Stimulus &stimulus) {
    if (stimulus.form == StimulusForm::pulse) {
        const double from_s = stimulus.pulse_from_s();
        return {2.0 / 3.0 * from_s, from_s};
    }
    return {0.5 * stimulus.presentation_s, stimulus.presentation_s};
}

DeliveryMeter::DeliveryMeter(const device::DeviceDescription &device, const Stimulus &stimulus,
                             double period_s)
    : device_(device), stimulus_(stimulus), period_s_(period_s),
      settled_(settled(stimulus)), pulse_{stimulus.pulse_from_s(), stimulus.pulse_from_s() +
                                                                       stimulus.pulse.length_s() +
                                                                       kAfterPulse_s} {}

/// Of the currents that flow by the law alone (11), from sample to sample.
Vector3 DeliveryMeter::law_force_N(const servo::ServoSample &sample, const Matrix3 &J) noexcept {
    const Vector3 k_T = control::torque_constants(sample.motor);
    if (!has_last_) {
        law_current_A_ = control::without_offsets(sample.current_A, sample.motor);
    } else {
        for (Eigen::Index j = 0; j < 3; ++j) {
            const double L_H = device_.motor[static_cast<std::size_t>(j)].inductance_H;
            const double left = std::exp(-last_dR_Ohm_[j] * period_s_ / L_H);
            const double rate_rad_per_s = (sample.theta_rad[j] - last_theta_rad_[j]) / period_s_;
            const double steady_A = (last_law_V_[j] - k_T[j] * rate_rad_per_s) / last_dR_Ohm_[j];
            law_current_A_[j] = left * law_current_A_[j] + (1.0 - left) * steady_A;
        }
    }
    has_last_ = true;
    last_theta_rad_ = sample.theta_rad;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const control::ObservedMotor &motor = sample.motor[static_cast<std::size_t>(j)];
        const double R_hat_Ohm = sample.command.cancelled_resistance_Ohm[j];
        last_dR_Ohm_[j] = motor.here.resistance_Ohm - R_hat_Ohm;
        last_law_V_[j] =
            sample.command.e_W_V[j] + R_hat_Ohm * motor.offset_A - sample.transfer_offset_V[j];
    }
    return J.transpose().inverse() * k_T.cwiseProduct(law_current_A_);
}

void DeliveryMeter::follow_speed(const servo::ServoSample &sample, bool is_approaching) noexcept {
    const Matrix3 J = device::motor_jacobian(
        device_.geometry, device::joint_from_motor(device_.geometry, sample.theta_rad));
    mean_velocity_m_per_s_ += -std::expm1(-period_s_ / kSpeedTime_s) *
                              (J * sample.theta_rate_rad_per_s - mean_velocity_m_per_s_);
    if (is_approaching) {
        speed_at_touch_m_per_s_ = -mean_velocity_m_per_s_.dot(stimulus_.frame.normal);
    }
}

void DeliveryMeter::take_press(const servo::ServoSample &sample) noexcept {
    const Vector3 &n = stimulus_.frame.normal;
    const double delta_m = n.dot(sample.contact.x0_m - sample.tip_m);
    force_sum_N_ += sample.tip_force_N;
    F_delta_sum_ += n.dot(sample.tip_force_N) * delta_m;
    delta_squares_m2_ += delta_m * delta_m;
    ++settled_ticks_;
}

void DeliveryMeter::take_pulse(const servo::ServoSample &sample, double since_s) noexcept {
    const Matrix3 J = device::motor_jacobian(
        device_.geometry, device::joint_from_motor(device_.geometry, sample.theta_rad));
    const Vector3 own_N = sample.tip_force_N - law_force_N(sample, J);
    if (settled_.holds(since_s)) {
        rest_sum_N_ += own_N;
        ++rest_ticks_;
    } else if (pulse_.holds(since_s)) {
        pulse_sum_N_ += own_N;
        ++pulse_ticks_;
    }
}

void DeliveryMeter::take_presented(const servo::ServoSample &sample, double since_s) noexcept {
    if (!has_begun_) {
        has_begun_ = true;
        so_far_.start_s = sample.time_s;
        touched_m_ = sample.tip_m;
    }
    so_far_.end_s = sample.time_s;
    so_far_.peak_force_N = std::max(so_far_.peak_force_N, sample.tip_force_N.norm());
    impulse_Ns_ += period_s_ * sample.tip_force_N;
    largest_speed_m_per_s_ = std::max(largest_speed_m_per_s_, mean_velocity_m_per_s_.norm());
    const Vector3 &n = stimulus_.frame.normal;
    const Vector3 moved_m = sample.tip_m - touched_m_;
    if (sample.contact.touching) {
        so_far_.aside_m = std::max(so_far_.aside_m, (moved_m - moved_m.dot(n) * n).norm());
        so_far_.deepest_m = std::max(so_far_.deepest_m, -moved_m.dot(n));
    }
    if (settled_.holds(since_s) && sample.contact.touching) {
        take_press(sample);
    }
    if (stimulus_.form == StimulusForm::pulse) {
        take_pulse(sample, since_s);
    }
}

void DeliveryMeter::take(const servo::ServoSample &sample, const StimulusRun &run) noexcept {
    follow_speed(sample, run.phase() == StimulusPhase::approaching);
    so_far_.generated_J = std::max(so_far_.generated_J, sample.generated_energy_J);
    so_far_.along_work_J = std::max(so_far_.along_work_J, run.steering().work_J());
    so_far_.lateness_s = std::max({so_far_.lateness_s, sample.missed_in_a_row * period_s_,
                                   sample.missed_periods * period_s_});
    so_far_.missed_deadlines += sample.missed_deadlines;
    so_far_.is_limited =
        so_far_.is_limited || sample.active_limits.holds_force() || sample.active_limits.voltage;
    so_far_.winding_C = estimated_windings_C(sample);
    if (run.phase() == StimulusPhase::presenting) {
        take_presented(sample, run.presented_s());
    }
}

DeliveredStimulus DeliveryMeter::delivered() const {
    DeliveredStimulus found = so_far_;
    StimulusMeasures &measures = found.measures;
    if (stimulus_.form == StimulusForm::stroke) {
        measures.speed_m_per_s = largest_speed_m_per_s_;
        return found;
    }
    if (!has_begun_) {
        return found;
    }
    Vector3 force = force_sum_N_;
    if (stimulus_.form == StimulusForm::blow) {
        measures.speed_m_per_s = speed_at_touch_m_per_s_;
        force = impulse_Ns_;
    } else if (settled_ticks_ > 0 && delta_squares_m2_ > 0.0) {
        measures.stiffness_N_per_m = F_delta_sum_ / delta_squares_m2_;
        measures.press_N = force.dot(stimulus_.frame.normal) / static_cast<double>(settled_ticks_);
    }
    if (stimulus_.form == StimulusForm::pulse) {
        if (rest_ticks_ == 0 || pulse_ticks_ == 0) {
            return found;
        }
        const Vector3 off_N = rest_sum_N_ / static_cast<double>(rest_ticks_);
        force = pulse_sum_N_ - static_cast<double>(pulse_ticks_) * off_N;
        measures.pulse_N = 2.0 * stimulus_.pulse.frequency_hz * period_s_ * force.norm();
    }
    if (!force.isZero(0.0)) {
        const ForceAngles angles = force_angles(stimulus_.frame, force);
        measures.turn_deg = angles.turn_deg;
        measures.across_deg = angles.across_deg;
    }
    return found;
}

LiveStimulus::LiveStimulus(const device::DeviceDescription &device, const Stimulus &stimulus,
                           double period_s)
    : run_(device, stimulus, period_s), meter_(device, stimulus, period_s),
      began_s_(std::numeric_limits<double>::quiet_NaN()), ended_s_(began_s_), failed_s_(began_s_),
      contact_(stimulus.contact) {}

void LiveStimulus::update(const servo::ServoSample &last, servo::LawInputs &next) noexcept {
    has_begun_.store(true, std::memory_order_release);
    const StimulusPhase before = run_.phase();
    run_.set_contact(contact_.latest());
    if (is_finished_.load(std::memory_order_acquire)) {
        run_.finish();
    }
    run_.update(last, next);
    if (before == StimulusPhase::done || before == StimulusPhase::failed) {
        return; // whoever waited for the end may be reading
    }
    meter_.take(last, run_);
    const StimulusPhase now = run_.phase();
    if (std::isnan(began_s_) && run_.presented_s() >= 0.0) {
        began_s_ = clock_of(last);
    }
    if (before == StimulusPhase::presenting) {
        ended_s_ = clock_of(last);
    }
    if (now == StimulusPhase::failed) {
        trip_ = last.safety;
        failed_s_ = clock_of(last);
    }
    phase_.store(now, std::memory_order_release);
}

} // namespace springdrive::study
