#include "engine/session/what_if.h"

#include "base/cancellation.h"
#include "device/core/motor/amplifier.h"
#include "engine/control/rendered_force.h"
#include "engine/servo/servo_sample.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace springdrive::session {

namespace {

/// After more periods without a measurement the currents start again as recorded.
constexpr int kMaxPeriods = 16;

/// A longer delay is taken as this one: a record may give any.
constexpr double kMaxDelayPeriods = 16.0;

/// Rows before a range that what_if computes, too: their effects on filters and currents decay with
/// time constants of up to 12 ms.
constexpr double kLeadIn_s = 0.5;

/// Whether this is known of a real motor, whose winding may carry current.
bool is_of_a_motor(const control::ObservedMotor &motor, const servo::WindingStatus &winding) {
    return winding.R_hat_limit_Ohm >= 0.0 && std::isfinite(motor.here.resistance_Ohm) &&
           motor.here.deviation_Ohm >= 0.0 && motor.mean.deviation_Ohm >= 0.0 &&
           std::isfinite(motor.offset_A) && std::isfinite(motor.torque_constant_Nm_per_A) &&
           motor.torque_constant_Nm_per_A > 0.0;
}

/// Whether a tick has only values that a servo can have: a record may be of any origin.
bool is_of_a_servo(const servo::ServoSample &sample) {
    const contact::Contact &contact = sample.contact;
    for (std::size_t motor = 0; motor < sample.motor.size(); ++motor) {
        if (!is_of_a_motor(sample.motor[motor], sample.winding[motor])) {
            return false;
        }
    }
    for (const servo::SafetyLimit &limit : servo::kSafetyLimits) {
        if (!(sample.limits.*limit.value >= 0.0)) {
            return false;
        }
    }
    return std::isfinite(sample.since_last_s) && sample.since_last_s >= 0.0 &&
           std::isfinite(sample.safety.ramp) && sample.transfer_offset_V.allFinite() &&
           contact.x0_m.allFinite() && contact.tangent_projector.allFinite() &&
           contact.normal.allFinite() && std::isfinite(contact.eta) &&
           std::isfinite(sample.global_alpha_rad2_per_m2);
}

Vector3 offsets_A(const control::ObservedMotors &motors) {
    return -control::without_offsets(Vector3::Zero(), motors);
}

} // namespace

PredictedCurrents::PredictedCurrents(const device::DeviceDescription &device, double delay_periods)
    : device_(device) {
    set_delay(delay_periods);
}

void PredictedCurrents::set_delay(double delay_periods) {
    delay_ = device::split_delay(std::clamp(delay_periods, 0.0, kMaxDelayPeriods));
}

bool PredictedCurrents::follows(const servo::ServoSample &recorded) const {
    return last_tick_ && *last_tick_ + 1 == recorded.tick;
}

/// Since the last measurement. Periods that had no tick are added to the commands, which were held.
int PredictedCurrents::periods_until(const servo::ServoSample &recorded) {
    const std::uint64_t ticks = recorded.tick - measured_->tick;
    const std::uint64_t periods = std::max<std::uint64_t>(ticks, recorded.missed_periods + 1ULL);
    if (periods > kMaxPeriods) {
        commands_.clear();
        return kMaxPeriods + 1;
    }
    for (std::uint64_t added = ticks; added < periods && !commands_.empty(); ++added) {
        const device::DeviceCommand held = commands_.back();
        commands_.push_back(held);
    }
    return static_cast<int>(periods);
}

Vector3 PredictedCurrents::at(const servo::ServoSample &recorded) {
    if (!follows(recorded)) {
        measured_.reset();
        commands_.clear();
    }
    last_tick_ = recorded.tick;
    const bool is_new = recorded.since_last_s > 0.0;
    const Vector3 offset_A = offsets_A(recorded.motor);
    if (!is_new && measured_) {
        return current_A_ + offset_A;
    }
    const int periods = measured_ ? periods_until(recorded) : 1;
    const std::size_t needed =
        static_cast<std::size_t>(periods) + static_cast<std::size_t>(delay_.held());
    if (measured_ && periods <= kMaxPeriods && commands_.size() >= needed &&
        current_A_.allFinite() && servo::lets_pass(recorded.safety.state)) {
        run(recorded, periods);
    } else {
        current_A_ = recorded.current_A - offset_A;
    }
    if (is_new) {
        measured_ = recorded;
    }
    constexpr std::size_t kMaxCommands = kMaxPeriods + 1 + 1;
    const std::size_t most = kMaxCommands + static_cast<std::size_t>(delay_.held());
    while (commands_.size() > most) {
        commands_.pop_front();
    }
    return current_A_ + offset_A;
}

/// With the commands that acted in each of the last periods, see device/core/split_delay.h.
void PredictedCurrents::run(const servo::ServoSample &recorded, int periods) {
    const double period_s = recorded.since_last_s / periods;
    for (int before = periods - 1; before >= 0; --before) {
        const std::size_t newer = commands_.size() - 1 - static_cast<std::size_t>(before) -
                                  static_cast<std::size_t>(delay_.whole);
        if (delay_.fraction > 0.0) {
            drive(commands_[newer - 1], recorded, delay_.fraction * period_s);
        }
        drive(commands_[newer], recorded, (1.0 - delay_.fraction) * period_s);
    }
}

void PredictedCurrents::drive(const device::DeviceCommand &command,
                              const servo::ServoSample &recorded, double duration_s) {
    if (command.mode == device::CommandMode::open) {
        current_A_.setZero();
        return;
    }
    const bool drives = command.mode == device::CommandMode::drive;
    for (std::size_t motor = 0; motor < 3; ++motor) {
        const auto j = static_cast<Eigen::Index>(motor);
        const control::ObservedMotor &known = recorded.motor[motor];
        device::MotorParameters parameters = device_.motor[motor];
        parameters.torque_constant_Nm_per_A = known.torque_constant_Nm_per_A;
        const double R_Ohm =
            0.5 * (measured_->motor[motor].here.resistance_Ohm + known.here.resistance_Ohm);
        const double rate_rad_per_s =
            (recorded.theta_rad[j] - measured_->theta_rad[j]) / recorded.since_last_s;
        const double R_hat_Ohm = drives ? std::clamp(command.cancelled_resistance_Ohm[j], 0.0,
                                                     device_.amplifier.max_cancelled_Ohm)
                                        : 0.0;
        // R̂ multiplies the reading of the current's sensor, with its offset (6).
        const double e_W_V = drives ? command.e_W_V[j] + R_hat_Ohm * known.offset_A : 0.0;
        current_A_[j] =
            device::spring_drive_step(parameters, {R_Ohm, current_A_[j], rate_rad_per_s, true},
                                      e_W_V, R_hat_Ohm, duration_s)
                .end_at(rate_rad_per_s);
    }
}

WhatIf::WhatIf(const device::DeviceDescription &device, double delay_periods,
               const control::Tuning &tuning)
    : tuning_(tuning), law_(device), replay_(device, tuning), currents_(device, delay_periods) {}

servo::ServoSample WhatIf::of(const servo::ServoSample &recorded) {
    if (!is_of_a_servo(recorded)) {
        return recorded; // for replay and currents, this tick is missing
    }
    servo::ServoSample answer = recorded;
    const Vector3 current_A = currents_.at(recorded);
    if (const std::optional<record::ReplayedTick> tick = replay_.take(recorded)) {
        take_law(*tick, answer);
        if (servo::lets_pass(recorded.safety.state)) {
            answer.current_A = current_A;
            take_force(*tick, answer);
        }
    }
    currents_.note(answer.command);
    return answer;
}

void WhatIf::take_law(const record::ReplayedTick &tick, servo::ServoSample &answer) const {
    const control::LawOutcome &found = tick.found;
    answer.tuning = tuning_;
    answer.theta_rate_rad_per_s = tick.now.theta_rate_rad_per_s;
    servo::note_law(law_, tick.now, found, answer);
    if (servo::lets_pass(answer.safety.state)) {
        answer.command.e_W_V = tick.command.e_W_V;
        answer.command.cancelled_resistance_Ohm = tick.command.cancelled_resistance_Ohm;
        answer.active_limits = tick.active_limits;
    }
}

void WhatIf::take_force(const record::ReplayedTick &tick, servo::ServoSample &answer) const {
    answer.tip_force_N =
        control::static_tip_force(tick.now.J, control::torque_constants(answer.motor),
                                  control::without_offsets(answer.current_A, answer.motor));
    servo::note_rendered_error(answer);
}

record::ChannelStore what_if(const Record &record, const control::Tuning &tuning,
                             const RowRange &rows) {
    TelemetryHistory answer = history_for(record.device.geometry, record.header);
    if (rows.from == rows.to) {
        return std::move(answer).take();
    }
    WhatIf tuned(record.device, record.header.delay_periods, tuning);
    const std::vector<DelayChange> delays = delays_of(record);
    const std::uint64_t first = record.store.row_at(record.store.time_s(rows.from) - kLeadIn_s);
    for (std::uint64_t row = first; row < rows.to; ++row) {
        stop_if_given_up();
        const servo::ServoSample recorded = sample_at(record.store, row);
        tuned.set_delay(delay_periods_at(recorded.tick, delays));
        const servo::ServoSample sample = tuned.of(recorded);
        answer.follow_rate(sample);
        if (row < rows.from) {
            answer.row_of(sample); // for the filter
        } else {
            answer.add(sample);
        }
    }
    return std::move(answer).take();
}

} // namespace springdrive::session
