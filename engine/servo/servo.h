// The servo: a loop on its own thread and clock, or in lockstep with whoever calls it.
//
//   window ── publish(ServoInputs) ──► mailbox ──► ┌─ thread: read, update, write ─┐
//   window ◄── drain(ServoSample)  ◄── ring    ◄── │                               │
//   recorder ◄── record_ring()     ◄── ring    ◄── └───────────────────────────────┘
//
// Nothing between the threads waits. Destroying the servo stops it; the last thing that the device
// hears is the safe state.
//
// A device that keeps the servo's clock, a simulated one, is a world that waits: while the host
// does not let the servo run, or the window is silent, its time stands still, and nothing of it
// was missed. Deadlines missed are counted all the same.
//
// An assertion that fails in a tick does not end the program: the device hears the safe state
// first, the tick is left, and all ticks after it measure and brake, whatever is asked of them.
// What failed stands in their samples. Only a new start leaves that: no button can know that a
// program which was wrong about its own state is right again.
#pragma once

#include "base/latest_value.h"
#include "base/sample_ring.h"
#include "engine/servo/real_time.h"
#include "engine/servo/servo_loop.h"

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace springdrive::servo {

inline constexpr double kSlowest_hz = 250.0;
inline constexpr double kFastest_hz = 10'000.0;

/// T = 1/rate [s].
/// @throw InputError for a rate that is not finite or not within these bounds.
[[nodiscard]] double servo_period_s(double servo_hz);

/// How the servo's thread is to run.
struct ServoThread {
    std::optional<int> cpu; ///< the processor to stay on
    std::function<void()>
        on_start{}; ///< called on it before its first tick, for a test to watch it
};

class Servo {
public:
    /// @throw InputError as `servo_period_s` does.
    Servo(device::HapticDevice &device, double servo_hz);
    ~Servo() { stop(); }
    Servo(const Servo &) = delete;
    Servo &operator=(const Servo &) = delete;

    /// New inputs from the next tick on. One thread at a time.
    void publish(const ServoInputs &inputs) noexcept { inputs_.publish(inputs); }

    /// Runs from now on a thread of its own, with real-time priority where allowed. Returns a
    /// remark for each thing that the system refused.
    std::vector<std::string> start(const ServoThread &how = {});

    /// Runs `ticks` ticks now, on the calling thread, without a clock. Not while started.
    /// Guarded against failed assertions as those of the thread are.
    void advance(int ticks);

    /// Ends the thread if there is one, and sends the safe state. Harmless twice.
    void stop() noexcept;

    /// Ends the thread if there is one, for a moment: the amplifiers hold the last command, and
    /// whoever paused may talk to the device. Tells whether it ran.
    bool pause() noexcept;

    /// Goes on as it was started, with all that it remembers.
    void resume();

    /// Another rate from the next tick on, in the midst of whatever goes on.
    /// @throw InputError as `servo_period_s` does, or the device; the old rate stays then
    void set_rate(double servo_hz);
    [[nodiscard]] double rate_hz() const { return servo_hz_; }

    /// Hands every sample since the last call to `take`, oldest first. The thread of `publish`.
    template <typename Take> void drain(Take &&take) { samples_.drain(take); }

    /// Samples lost because `drain` came too late.
    [[nodiscard]] std::uint64_t lost_samples() const { return samples_.lost(); }

    /// Every sample goes here too while `feed_recorder` is on, for one more reader.
    [[nodiscard]] SampleRing<ServoSample> &record_ring() { return record_samples_; }
    void feed_recorder(bool on) noexcept { recording_.store(on, std::memory_order_release); }

    [[nodiscard]] double period_s() const { return loop_.period_s(); }

    /// Whether no thread of its own ticks.
    [[nodiscard]] bool is_at_rest() const { return !thread_.joinable(); }

private:
    using Clock = std::chrono::steady_clock;

    void run() noexcept;
    template <typename Ticks> [[nodiscard]] bool have_completed(const Ticks &ticks) noexcept;
    std::vector<std::string> run_on_a_thread();
    void hand_over(const ServoSample &sample) noexcept;

    double servo_hz_;
    ServoThread how_; ///< its thread was started
    bool has_started_ = false;
    std::optional<Clock::time_point> origin_; ///< of its clock
    ServoLoop loop_;
    LatestValue<ServoInputs> inputs_;
    SampleRing<ServoSample> samples_;
    SampleRing<ServoSample> record_samples_;
    std::atomic<bool> recording_{false};

    std::atomic<bool> stopping_{false};
    bool stopped_ = false;
    std::thread thread_;
    std::optional<ShortIdle> short_idle_;
};

} // namespace springdrive::servo
