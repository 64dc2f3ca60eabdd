#include "engine/session/servo_run.h"

#include "base/assertions.h"
#include "base/input_error.h"
#include "base/new_file.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace springdrive::session {

ServoRun::ServoRun(device::HapticDevice &device, const ServoOptions &way)
    : way_(way), device_(&device), servo_(std::make_unique<servo::Servo>(device, way.servo_hz)),
      history_(device.description().geometry, way.servo_hz, way.history_bytes) {
    publish();
}

/// Before the first frame nobody would notice that the window stands still: no motor is driven.
void ServoRun::publish() {
    servo::ServoInputs inputs = inputs_;
    inputs.release = inputs.release || (!way_.lockstep && inputs.heartbeat == 0);
    servo_->publish(inputs);
}

void ServoRun::tune(const control::Tuning &tuning) {
    inputs_.tuning = tuning;
    publish();
}

void ServoRun::set_global_alpha(double alpha_rad2_per_m2) {
    inputs_.global_alpha_rad2_per_m2 = alpha_rad2_per_m2;
    publish();
}

void ServoRun::observe_resistance(bool on, bool has_inductance) {
    inputs_.observes_resistance = on && has_inductance;
    inputs_.has_inductance = has_inductance;
    publish();
}

void ServoRun::lower_limits(const servo::SafetyLimits &limits) {
    inputs_.limits = limits;
    publish();
}

void ServoRun::emergency_stop() {
    inputs_.requested_stop = std::max(inputs_.released_stop, latest_.safety.held_stop) + 1;
    publish();
    step(); // a device that stands still is stopped at once, too
}

void ServoRun::reset_safety() {
    ++inputs_.reset_count;
    publish();
    step();
}

void ServoRun::let_go_on() {
    inputs_.released_stop = std::max(inputs_.released_stop, shown_stop_);
    reset_safety();
}

void ServoRun::resume_watch(const std::array<device::MotorTemperature, 3> &hottest) {
    inputs_.hottest = hottest;
    ++inputs_.unwatched_count;
    publish();
    for (std::size_t j = 0; j < hottest.size(); ++j) { // until the next sample
        servo::WindingStatus &winding = latest_.winding[j];
        winding.max_C = std::max(winding.max_C, hottest[j].winding_C);
        winding.max_housing_C = std::max(winding.max_housing_C, hottest[j].housing_C);
    }
}

void ServoRun::touch(const contact::HapticSurface &surface, std::uint32_t scene_id,
                     const control::Tuning &tuning) {
    inputs_.tuning = tuning;
    inputs_.surface = &surface;
    inputs_.scene_id = scene_id;
    publish();
}

void ServoRun::follow(servo::InputSchedule *schedule) {
    inputs_.schedule = schedule;
    publish();
}

double ServoRun::now_s() const { return is_in_lockstep() ? latest_.time_s : servo_->clock_s(); }

void ServoRun::touch_nothing() {
    inputs_.surface = nullptr;
    publish();
}

void ServoRun::release(bool requested) {
    inputs_.release = requested;
    publish();
}

std::vector<std::string> ServoRun::start(const std::function<void()> &on_thread) {
    if (way_.lockstep) {
        return {};
    }
    return servo_->start({way_.cpu, on_thread});
}

void ServoRun::advance(double frame_s) {
    shown_stop_ = drawn_stop_;
    inputs_.heartbeat = std::max(1U, inputs_.heartbeat + 1U);
    publish();
    if (!is_halted() && (way_.lockstep || speed_ < 1.0)) {
        pending_ticks_ += speed_ * frame_s * rate_hz();
        const int due = static_cast<int>(std::floor(pending_ticks_ + 1e-9));
        pending_ticks_ -= due;
        servo_->advance(due);
    }
    take_in();
    drawn_stop_ = latest_.safety.held_stop;
}

bool ServoRun::can_change_speed() const {
    return !is_halted() && device_->clock() == device::DeviceClock::servo;
}

void ServoRun::set_speed(double speed) {
    if (!can_change_speed()) {
        return;
    }
    const double before = std::exchange(speed_, std::clamp(speed, 0.0, 1.0));
    pending_ticks_ = 0.0;
    if (way_.lockstep) {
        return; // has no thread
    }
    if (before == 1.0 && speed_ < 1.0) {
        servo_->pause();
    } else if (before < 1.0 && speed_ == 1.0) {
        servo_->resume();
    }
}

void ServoRun::step() {
    if (speed_ == 0.0 && !is_halted()) {
        servo_->advance(1);
        take_in();
    }
}

void ServoRun::take_in() {
    servo_->drain([this](const servo::ServoSample &sample) {
        latest_ = sample;
        next_tick_ = sample.tick + 1;
        statistics_.add(sample);
        history_.add(sample);
        note_stall(sample);
    });
}

void ServoRun::note_stall(const servo::ServoSample &sample) {
    if (device_->clock() != device::DeviceClock::servo || sample.missed_deadlines == 0) {
        return;
    }
    ++stalls_.times;
    stalls_.seconds += sample.missed_deadlines * period_s();
    stalls_.longest_s = std::max(stalls_.longest_s, sample.missed_in_a_row * period_s());
}

void ServoRun::stop() {
    servo_->stop();
    take_in();
}

/// Pauses the thread if `may` holds, also with its last sample. Returns whether there was one that
/// ran; empty if it may not, and goes on.
std::optional<bool> ServoRun::pause_if(const std::function<bool()> &may) {
    if (!may()) {
        return std::nullopt;
    }
    const bool ran = servo_->pause();
    take_in(); // the latest sample may have been outdated
    if (may()) {
        return ran;
    }
    if (ran) {
        servo_->resume();
    }
    return std::nullopt;
}

bool ServoRun::stop_if_released() {
    const auto is_released = [this] {
        return !servo::lets_pass(latest_.safety.state) && !has_failed();
    };
    if (!pause_if(is_released)) {
        return false;
    }
    stop();
    return true;
}

bool ServoRun::halt_if_released() {
    if (is_halted()) {
        return false;
    }
    halt_ = pause_if([this] {
        return latest_.safety.state == servo::SafetyState::waiting && inputs_.release &&
               !has_failed();
    });
    return is_halted();
}

void ServoRun::go_on() {
    const std::optional<bool> ran = std::exchange(halt_, std::nullopt);
    if (!ran) {
        return;
    }
    servo_->expect_gap();
    pending_ticks_ = 0.0;
    if (*ran) {
        servo_->resume();
    }
}

void ServoRun::paused(const std::function<void()> &step) {
    SPRINGDRIVE_ASSERT(!is_halted());
    const bool ran = servo_->pause();
    const auto resume = [&] {
        servo_->expect_gap();
        if (ran) {
            servo_->resume();
        }
    };
    take_in();
    try {
        step();
    } catch (...) {
        resume();
        throw;
    }
    resume();
}

std::uint64_t ServoRun::set_rate(double servo_hz) {
    const double before_hz = rate_hz();
    paused([&] {
        servo_->set_rate(servo_hz);
        pending_ticks_ *= servo_hz / before_hz;
        history_.set_rate(servo_hz);
        statistics_ = {};
        stalls_ = {};
    });
    return next_tick_;
}

void ServoRun::renew(device::HapticDevice &device) {
    SPRINGDRIVE_ASSERT(servo_->is_at_rest() && !has_failed());
    const double servo_hz = rate_hz();
    lost_ = lost_samples();
    history_.set_device(device.description().geometry);
    device_ = &device;
    servo_ = std::make_unique<servo::Servo>(device, servo_hz);
    inputs_.requested_stop = std::max(inputs_.requested_stop, latest_.safety.held_stop);
    if (latest_.safety.state == servo::SafetyState::tripped && !is_held_stopped()) {
        inputs_.requested_stop = inputs_.released_stop + 1; // the new servo knows of no trip
    }
    inputs_.reset_count = 0; // as the new loop's: only a difference is a request
    inputs_.unwatched_count = 0;
    inputs_.release = false;
    next_tick_ = 0;
    latest_.time_s = 0.0; // of the new servo, whose first sample is still to come
    latest_.winding = {};
    speed_ = 1.0;
    statistics_ = {};
    stalls_ = {};
    publish();
}

namespace {

/// The sum of two consecutive parts.
record::RecorderStatus sum(const record::RecorderStatus &first,
                           const record::RecorderStatus &second) {
    return {first.rows + second.rows, first.bytes + second.bytes, first.lost + second.lost,
            first.error.empty() ? second.error : first.error};
}

} // namespace

Recording::Recording(ServoRun &servo) : servo_(servo) {}

void Recording::begin(const std::filesystem::path &file, const record::RecordHeader &header,
                      FilePolicy policy) {
    if (!recorder_) {
        recorder_ = std::make_unique<record::Recorder>(servo_.servo().record_ring());
    }
    recorder_->start(file, header,
                     servo_.is_in_lockstep() ? record::Recorder::Mode::pumped
                                             : record::Recorder::Mode::own_thread,
                     policy);
    servo_.servo().feed_recorder(true);
}

void Recording::start(const std::filesystem::path &file, const record::RecordHeader &header,
                      FilePolicy policy) {
    begin(file, header, policy);
    parts_ = {file};
    readers_ = policy.readers;
    ended_ = {};
}

void Recording::stop() {
    servo_.servo().feed_recorder(false);
    if (recorder_) {
        recorder_->stop();
    }
}

void Recording::end_part(std::string_view last_note) {
    goes_on_ = is_running();
    servo_.servo().feed_recorder(false);
    if (recorder_) {
        recorder_->stop(last_note);
        ended_ = sum(ended_, recorder_->status());
        recorder_.reset();
    }
}

std::filesystem::path Recording::begin_part(const record::RecordHeader &header) {
    if (!std::exchange(goes_on_, false)) {
        return {};
    }
    // What exists from an earlier recording is not overwritten.
    std::filesystem::path file = unused_name(parts_.front(), parts_.size() + 1);
    try {
        begin(file, header, {Existing::keep, readers_});
    } catch (const InputError &error) {
        ended_.error = error.what();
        throw;
    }
    parts_.push_back(file);
    return file;
}

record::RecorderStatus Recording::status() const {
    return recorder_ ? sum(ended_, recorder_->status()) : ended_;
}

} // namespace springdrive::session
