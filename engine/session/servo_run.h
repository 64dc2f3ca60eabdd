// The run of a servo: what is asked of it, what came back, and how well it keeps its time. Goes on
// over changes of scene, rate and device.
#pragma once

#include "engine/servo/servo.h"
#include "engine/servo/servo_statistics.h"
#include "engine/session/history.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::session {

/// How a servo is to run.
struct ServoWay {
    double servo_hz = 1000.0;
    bool lockstep = false;  ///< it goes by `ServoRun::advance`, not by a clock
    std::optional<int> cpu; ///< that its thread is to stay on
};

/// How long a world that waits for its servo stood still, since the host did not let that run.
struct StoodStill {
    std::uint64_t times = 0;
    double seconds = 0.0;
    double longest_s = 0.0; ///< in a row, with what was late in between
};

/// Of one thread.
class ServoRun {
public:
    /// @param device  must outlive it, or the call of `renew`
    /// @throw InputError as `servo_period_s` does
    ServoRun(device::HapticDevice &device, const ServoWay &way);

    // What is asked; in force from the next tick.
    void tune(const control::Tuning &tuning);
    void set_global_alpha(double alpha_rad2_per_m2);
    void lower_limits(const servo::SafetyLimits &limits);
    void emergency_stop();
    void reset_safety();
    /// @param surface  must outlive the time until a sample has a later `scene_id`
    void touch(const contact::HapticSurface &surface, std::uint32_t scene_id,
               const control::Tuning &tuning);
    /// To let the force fade and keep the motors braking until further notice.
    void release(bool asked);

    /// Starts its thread, unless in lockstep. Returns what the system refused.
    /// @param on_thread  see ServoThread
    std::vector<std::string> start(const std::function<void()> &on_thread = {});

    /// Moves on by one frame: gives a sign of life, in lockstep ticks, takes in what came back.
    void advance(double frame_s);

    /// Takes in what came back since.
    void take_in();

    /// Sends the safe state last, and takes in the last samples. Harmless twice.
    void stop();

    /// Stops as `stop` does if the motors have nothing of the command, as after `release` or a
    /// trip; else, and after a failed assertion, tells false, and nothing has changed.
    [[nodiscard]] bool stop_if_released();

    /// Runs `step` while the servo's thread does not run, and all its samples are taken in:
    /// whoever does so may talk to the device. It goes on afterwards, whatever `step` throws.
    void paused(const std::function<void()> &step);

    /// Another rate from the next tick on. Statistics count anew; returns that tick's number.
    /// @throw InputError as Servo::set_rate does; nothing has changed then
    std::uint64_t set_rate(double servo_hz);

    /// Begins anew on another device, with what was asked before, but to release. Has to be
    /// started. An emergency stop that was given stays given.
    /// @pre its thread does not run, and no assertion failed on it
    void renew(device::HapticDevice &device);

    [[nodiscard]] double rate_hz() const { return servo_->rate_hz(); }
    [[nodiscard]] double period_s() const { return servo_->period_s(); }
    [[nodiscard]] bool is_in_lockstep() const { return way_.lockstep; }
    [[nodiscard]] const servo::ServoInputs &inputs() const { return inputs_; }
    [[nodiscard]] const servo::ServoSample &latest() const { return latest_; }
    /// Whether an assertion failed in a tick: the motors brake for good.
    [[nodiscard]] bool has_failed() const { return servo::is_final(latest_.safety.cause); }
    [[nodiscard]] const History &history() const { return history_; }
    /// Since the last change of rate or device.
    [[nodiscard]] const servo::ServoStatistics &statistics() const { return statistics_; }
    [[nodiscard]] const StoodStill &stood_still() const { return stood_still_; }
    /// That this thread was too slow to take in.
    [[nodiscard]] std::uint64_t lost_samples() const { return lost_ + servo_->lost_samples(); }

    /// For a recorder. Another one after `renew`.
    [[nodiscard]] servo::Servo &servo() { return *servo_; }

private:
    void publish() { servo_->publish(inputs_); }
    void note_standstill(const servo::ServoSample &sample);

    ServoWay way_;
    device::HapticDevice *device_;
    std::unique_ptr<servo::Servo> servo_;
    servo::ServoInputs inputs_;
    double debt_ticks_ = 0.0; ///< of lockstep
    std::uint64_t lost_ = 0;  ///< of servos before
    servo::ServoSample latest_;
    std::uint64_t next_tick_ = 0; ///< after the latest
    servo::ServoStatistics statistics_;
    StoodStill stood_still_;
    History history_;
};

} // namespace springdrive::session
