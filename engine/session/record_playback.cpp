#include "engine/session/record_playback.h"

#include "base/assertions.h"
#include "base/cancellation.h"
#include "device/core/motor/motor.h"
#include "engine/control/rendered_force.h"
#include "engine/servo/servo_sample.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <limits>
#include <utility>
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
           motor.torque_constant_Nm_per_A > 0.0 && motor.load >= 0.0 && motor.load <= 1.0;
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

namespace {

/// A tenth of a second's work, so that answers follow a slider: 20 s at 1 kHz.
constexpr std::uint64_t kRowsAnsweredFirst = 20'000;

} // namespace

void RecordPlayback::open(const std::filesystem::path &file, double from_s) {
    error_.clear();
    loading_.start([file, from_s](BackgroundTalk &talk) {
        return std::make_shared<const Record>(load_record(file, from_s, kMaxBytes, talk));
    });
}

void RecordPlayback::close() {
    loading_.give_up();
    drop_record();
    error_.clear();
    is_playing_ = false;
    position_s_ = 0.0;
}

const Record &RecordPlayback::record() const {
    SPRINGDRIVE_ASSERT(record_ != nullptr);
    return *record_;
}

RunScene RecordPlayback::scene() const {
    const auto noted = scenes_.find(sample().scene_id);
    return noted != scenes_.end()
               ? noted->second
               : RunScene{record().header.scene_file, record().header.scene_sha256};
}

void RecordPlayback::seek(double time_s) {
    if (is_open() && !std::isnan(time_s)) {
        const RowTimes times = record_->times();
        position_s_ = std::clamp(time_s, times.first_s, times.last_s);
    }
}

void RecordPlayback::step(int rows) {
    is_playing_ = false;
    if (!is_open()) {
        return;
    }
    const record::ChannelStore &store = record_->store;
    const std::uint64_t now = row();
    const std::uint64_t back = rows < 0 ? static_cast<std::uint64_t>(-std::int64_t{rows}) : 0;
    const std::uint64_t on = rows > 0 ? static_cast<std::uint64_t>(rows) : 0;
    const std::uint64_t then = now - std::min(back, now - store.begin());
    position_s_ = store.time_s(std::min(then + on, store.end() - 1));
}

void RecordPlayback::set_speed(double speed) {
    if (std::isfinite(speed)) {
        speed_ = std::clamp(speed, -kMaxSpeed, kMaxSpeed);
    }
}

void RecordPlayback::play(bool on) {
    is_playing_ = on && is_open();
    if (!is_playing_) {
        return;
    }
    const RowTimes times = record_->times();
    if (speed_ > 0.0 && position_s_ >= times.last_s) {
        position_s_ = times.first_s;
    } else if (speed_ < 0.0 && position_s_ <= times.first_s) {
        position_s_ = times.last_s;
    }
}

void RecordPlayback::advance(double frame_s) {
    take_record();
    move(frame_s);
    take_answer();
    go_on_answering();
}

void RecordPlayback::take_record() {
    try {
        if (std::optional<SharedRecord> loaded = loading_.take()) {
            drop_record();
            record_ = std::move(*loaded);
            position_s_ = record_->times().first_s;
            scenes_ = noted_scenes(*record_);
            is_playing_ = false;
        }
    } catch (const std::exception &error) {
        error_ = error.what();
    }
}

void RecordPlayback::move(double frame_s) {
    if (!is_playing_ || !std::isfinite(frame_s)) {
        return;
    }
    seek(position_s_ + speed_ * frame_s);
    const RowTimes times = record_->times();
    const bool is_at_end =
        speed_ > 0.0 ? position_s_ >= times.last_s : speed_ < 0.0 && position_s_ <= times.first_s;
    is_playing_ = !is_at_end;
}

/// Whoever drops the last reference to a record waits until its memory is returned.
void RecordPlayback::drop_record() {
    answering_.give_up();
    drop_answer();
    failed_.reset();
    if (record_) {
        release_record_.let_go(std::make_unique<SharedRecord>(std::move(record_)));
        record_.reset();
    }
}

void RecordPlayback::drop_answer() {
    if (answer_) {
        release_answer_.let_go(std::move(answer_));
    }
}

void RecordPlayback::ask(const control::Tuning &tuning) {
    if (asked_ == tuning || !control::is_valid(tuning)) {
        return;
    }
    stop_reporting_failure();
    asked_ = tuning;
    if (running_completes_) {
        answering_.ask_to_end();
    }
    go_on_answering();
}

void RecordPlayback::stop_asking() {
    stop_reporting_failure();
    asked_.reset();
    answering_.give_up();
    drop_answer();
}

void RecordPlayback::stop_reporting_failure() {
    if (failed_) {
        failed_.reset();
        error_.clear();
    }
}

void RecordPlayback::take_answer() {
    try {
        if (std::optional<std::unique_ptr<Answer>> found = answering_.take()) {
            drop_answer();
            answer_ = std::move(*found);
        }
    } catch (const Cancelled &) { // for a newer question
    } catch (const std::exception &error) {
        failed_ = running_tuning_;
        error_ = std::string("the record cannot be computed with this tuning: ") + error.what();
    }
}

RowRange RecordPlayback::rows_to_answer_first() const {
    const record::ChannelStore &store = record_->store;
    const std::uint64_t here = row();
    const std::uint64_t before = std::min(kRowsAnsweredFirst / 2, here - store.begin());
    const std::uint64_t from = here - before;
    return {from, std::min(store.end(), from + kRowsAnsweredFirst)};
}

/// Starts the next computation, if one is missing.
void RecordPlayback::go_on_answering() {
    if (!is_open() || !asked_ || asked_ == failed_ || answering_.is_busy()) {
        return;
    }
    const bool has_begun = answer_ && answer_->tuning == *asked_;
    if (has_begun && answer_->is_complete) {
        return;
    }
    const RowRange all = record_->rows;
    const RowRange rows = has_begun ? all : rows_to_answer_first();
    running_tuning_ = *asked_;
    running_completes_ = has_begun;
    const bool is_complete = rows.from == all.from && rows.to == all.to;
    answering_.start([record = record_, tuning = *asked_, rows, is_complete](BackgroundTalk &) {
        return std::make_unique<Answer>(
            Answer{tuning, is_complete, rows, what_if(*record, tuning, rows)});
    });
}

std::optional<servo::ServoSample> RecordPlayback::answered_sample() const {
    if (!answer_) {
        return std::nullopt;
    }
    const std::uint64_t shown = row();
    if (shown < answer_->rows.from || shown >= answer_->rows.to) {
        return std::nullopt;
    }
    return sample_at(answer_->store, answer_->store.begin() + (shown - answer_->rows.from));
}

} // namespace springdrive::session
