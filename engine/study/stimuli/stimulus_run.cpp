#include "engine/study/stimuli/stimulus_run.h"

#include "device/core/phantom/kinematics.h"
#include "engine/servo/bumpless_transfer.h"

#include <cmath>

namespace springdrive::study {

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
    const Vector3 wanted_N =
        has_given_up_ ? Vector3(Vector3::Zero()) : Vector3(share * pressed_N * slope_);
    integral_N_ += gap_share_ * (wanted_N - last_force_N_);
    const Vector3 at_once_N = is_prompt_ ? wanted_N : Vector3(Vector3::Zero());
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

} // namespace springdrive::study
