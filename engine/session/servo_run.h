// The run of a servo: its inputs, its samples, its timing and its recording. Continues through
// changes of scene, rate and device.
#pragma once

#include "engine/record/recorder.h"
#include "engine/servo/servo.h"
#include "engine/servo/servo_timing.h"
#include "engine/session/telemetry_history.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::session {

/// Options for running a servo.
struct ServoOptions {
    double servo_hz = 1000.0;
    bool lockstep = false;  ///< timed by `ServoRun::advance`, not by a clock
    std::optional<int> cpu; ///< the processor of its thread
    std::size_t history_bytes = TelemetryHistory::kMaxBytes;
};

/// How long a simulated device, which waits for its servo, was paused because the host did not run
/// the servo.
struct Stalls {
    std::uint64_t times = 0;
    double seconds = 0.0;
    double longest_s = 0.0; ///< consecutive, including late ticks in between
};

class Session;

/// For use by one thread.
class ServoRun {
public:
    /// @param device  must outlive this object or stay valid until `renew`
    /// @throw InputError as `servo_period_s` does
    ServoRun(device::HapticDevice &device, const ServoOptions &way);

    // Requests; active from the next tick.
    void set_global_alpha(double alpha_rad2_per_m2);
    void observe_resistance(bool on, bool has_inductance);
    void lower_limits(const servo::SafetyLimits &limits);
    void emergency_stop();
    /// After a trip; not by a person: without effect while a stop is held.
    void reset_safety();
    /// A person lets the device go on, after any stop that the previous frame showed.
    void let_go_on();
    /// For a time that is not known nobody watched the windings, which are now at most as hot as
    /// before, or as `hottest`.
    void resume_watch(const std::array<device::MotorTemperature, 3> &hottest);
    /// @param surface  must stay valid until a sample has a later `scene_id`
    void touch(const contact::HapticSurface &surface, std::uint32_t scene_id,
               const control::Tuning &tuning);
    /// Lets a schedule change tuning, excitation and x₀ from tick to tick; null: nothing does. It
    /// must live until a later one has been updated, or the servo stopped.
    void follow(servo::InputSchedule *schedule);
    /// Free space from now on: until `touch`, nothing is there.
    void touch_nothing();
    /// Ramps the force down and keeps the motors braking until called with false.
    void release(bool requested);

    /// Starts the servo's thread, unless in lockstep. Returns warnings on what the system refused.
    /// @param on_thread  see ServoThread
    std::vector<std::string> start(const std::function<void()> &on_thread = {});

    /// Advances by one frame: sends the heartbeat, runs the ticks in lockstep, fetches samples.
    void advance(double frame_s);

    /// Fetches new samples.
    void take_in();

    /// Sends the safe state last, and fetches the last samples. May be called twice.
    void stop();

    /// Stops as `stop` does if no command reaches the motors, as after `release` or a trip;
    /// otherwise, and after a failed assertion, returns false and changes nothing.
    [[nodiscard]] bool stop_if_released();

    /// Stands still if no command reaches the motors, as after `release`: until `go_on`, no tick
    /// runs, and the caller may use the device. Otherwise, and after a trip or a failed assertion,
    /// returns false and changes nothing.
    [[nodiscard]] bool halt_if_released();
    void go_on();
    [[nodiscard]] bool is_halted() const { return halt_.has_value(); }

    /// A simulated device, which waits for its servo, can be slowed down or stand still: its servo
    /// then runs in frames, like in lockstep. Others always have speed 1.
    /// @param speed  of the device's time, 0 to 1
    void set_speed(double speed);
    [[nodiscard]] double speed() const { return speed_; }
    [[nodiscard]] bool can_change_speed() const;
    /// One tick of a device that stands still; of others none.
    void step();

    /// Runs `step` while the servo's thread is paused and all its samples have been fetched: `step`
    /// may use the device. The thread resumes afterwards, even if `step` throws.
    void paused(const std::function<void()> &step);

    /// Changes the rate from the next tick on and resets the statistics; returns that tick's
    /// number.
    /// @throw InputError as Servo::set_rate does; nothing is then changed
    std::uint64_t set_rate(double servo_hz);

    /// Restarts on another device with the same inputs, except for `release`. Must be started. A
    /// held stop stays held, and a trip becomes one.
    /// @pre the servo's thread is not running, and no assertion failed on it
    void renew(device::HapticDevice &device);

    [[nodiscard]] double rate_hz() const { return servo_->rate_hz(); }
    [[nodiscard]] double period_s() const { return servo_->period_s(); }
    /// Now, by the clock of `ServoSample::clock_s`; in lockstep the time of the latest sample.
    [[nodiscard]] double now_s() const;
    [[nodiscard]] bool is_in_lockstep() const { return way_.lockstep; }
    [[nodiscard]] const servo::ServoInputs &inputs() const { return inputs_; }
    [[nodiscard]] const servo::ServoSample &latest() const { return latest_; }
    /// Whether a requested stop holds, also one that no tick has seen yet, until a person lets the
    /// device go on.
    [[nodiscard]] bool is_held_stopped() const {
        return std::max(inputs_.requested_stop, latest_.safety.held_stop) > inputs_.released_stop;
    }
    /// Whether an assertion failed in a tick: the motors then brake permanently.
    [[nodiscard]] bool has_failed() const { return servo::is_final(latest_.safety.cause); }
    [[nodiscard]] const TelemetryHistory &history() const { return history_; }
    /// Since the last change of rate or device.
    [[nodiscard]] const servo::ServoStatistics &statistics() const { return statistics_; }
    [[nodiscard]] const Stalls &stalls() const { return stalls_; }
    /// Samples lost because this thread was too slow.
    [[nodiscard]] std::uint64_t lost_samples() const { return lost_ + servo_->lost_samples(); }

    /// For a recorder. Replaced by `renew`.
    [[nodiscard]] servo::Servo &servo() { return *servo_; }

private:
    friend class Session; // owns the tuning

    void tune(const control::Tuning &tuning);
    void publish();
    [[nodiscard]] std::optional<bool> pause_if(const std::function<bool()> &may);
    void note_stall(const servo::ServoSample &sample);

    ServoOptions way_;
    device::HapticDevice *device_;
    std::unique_ptr<servo::Servo> servo_;
    servo::ServoInputs inputs_;
    std::uint32_t drawn_stop_ = 0; ///< held when the present frame is drawn
    std::uint32_t shown_stop_ = 0; ///< held when the previous one was drawn
    double speed_ = 1.0;
    std::optional<bool> halt_;   ///< while it stands still: whether the thread ran before
    double pending_ticks_ = 0.0; ///< fraction of a tick due in lockstep, or slowed down
    std::uint64_t lost_ = 0;     ///< by previous servos
    servo::ServoSample latest_;
    std::uint64_t next_tick_ = 0; ///< the one after `latest_`
    servo::ServoStatistics statistics_;
    Stalls stalls_;
    TelemetryHistory history_;
};

// Records a servo's run, in one file per device that it ran on.
//
//   touch.rec ──another device──► touch-2.rec ──another device──► touch-3.rec

/// For use by one thread.
class Recording {
public:
    /// @param servo  must outlive it
    explicit Recording(ServoRun &servo);

    /// Records every tick from now on. A running recording is stopped first.
    /// @param policy  whether a file of that name is replaced; further parts replace none
    /// @throw InputError if the file cannot be created
    void start(const std::filesystem::path &file, const record::RecordHeader &header,
               FilePolicy policy = Existing::keep);
    void stop();

    /// In lockstep: writes the new samples.
    void pump() {
        if (recorder_) {
            recorder_->pump();
        }
    }

    /// Records an event between two ticks, as JSON text; does nothing while not recording.
    void note(std::string_view json) {
        if (recorder_) {
            recorder_->note(json);
        }
    }

    /// Ends the current file, if any, with all ticks up to now, and detaches from the servo.
    /// @param last_note  JSON text
    void end_part(std::string_view last_note);

    /// Continues after `ServoRun::renew`: if a file was ended, starts a new one and returns its
    /// name.
    /// @throw InputError if the file cannot be created; the recording has then ended
    std::filesystem::path begin_part(const record::RecordHeader &header);

    [[nodiscard]] bool is_running() const { return recorder_ && recorder_->is_recording(); }
    /// The status of all parts of the current recording, or else of the last one.
    [[nodiscard]] record::RecorderStatus status() const;
    /// The current file, or else the last one; empty if there was none.
    [[nodiscard]] std::filesystem::path file() const {
        return parts_.empty() ? std::filesystem::path() : parts_.back();
    }
    /// All files, in the order in which they were written.
    [[nodiscard]] const std::vector<std::filesystem::path> &parts() const { return parts_; }

private:
    void begin(const std::filesystem::path &file, const record::RecordHeader &header,
               FilePolicy policy);

    ServoRun &servo_;
    std::unique_ptr<record::Recorder> recorder_; ///< on the servo's ring; null before the first
    std::vector<std::filesystem::path> parts_;
    Readers readers_ = Readers::all; ///< of the parts
    record::RecorderStatus ended_;   ///< sum of the previous parts
    bool goes_on_ = false;           ///< between the end of a part and the start of the next
};

} // namespace springdrive::session
