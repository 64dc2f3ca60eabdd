#include "engine/study/stimuli/delivery_meter.h"

#include "device/core/phantom/kinematics.h"
#include "engine/study/stimuli/warm_up.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace springdrive::study {

namespace {

constexpr double kSpeedTime_s = 0.01;

} // namespace

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

} // namespace springdrive::study
