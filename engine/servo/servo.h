// The servo: a loop on its own thread and clock, or in lockstep with its caller.
//
//   window ── publish(ServoInputs) ──► mailbox ──► ┌─ thread: read, update, write ─┐
//              with an InputSchedule, which then changes them from tick to tick
//   window ◄── drain(ServoSample)  ◄── ring    ◄── │                               │
//   recorder ◄── record_ring()     ◄── ring    ◄── └───────────────────────────────┘
//
// The threads never wait for each other. Destroying the servo stops it; the last command to the
// device is the safe state.
//
// A device on the servo's clock, i.e. a simulated one, waits for the servo: while the host does not
// run the servo, or the window's heartbeat stops, device time is paused, and no device period is
// missed. Missed deadlines are counted nevertheless.
//
// An assertion that fails in a tick does not end the program: the device is first commanded to the
// safe state, the tick is abandoned, and all later ticks only measure and brake, regardless of
// requests. Their samples report the failure. Only a restart of the program clears it, because its
// state can no longer be trusted.
#pragma once

#include "base/hand_over.h"
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

inline constexpr double kMinRate_hz = 250.0;
inline constexpr double kMaxRate_hz = 10'000.0;

/// T = 1/rate [s].
/// @throw InputError for a rate that is not finite or outside of these bounds.
[[nodiscard]] double servo_period_s(double servo_hz);

/// Options of the servo's thread.
struct ServoThread {
    std::optional<int> cpu;           ///< the processor to run on
    std::function<void()> on_start{}; ///< called on the thread before its first tick, for tests
};

class Servo {
public:
    /// @throw InputError as `servo_period_s` does.
    Servo(device::HapticDevice &device, double servo_hz);
    ~Servo() { stop(); }
    Servo(const Servo &) = delete;
    Servo &operator=(const Servo &) = delete;

    /// Sets the inputs from the next tick on. One thread at a time.
    void publish(const ServoInputs &inputs) noexcept { inputs_.publish(inputs); }

    /// Starts the servo's own thread, with real-time priority if permitted. Returns a warning for
    /// each request that the system refused.
    std::vector<std::string> start(const ServoThread &how = {});

    /// Runs `ticks` ticks now, on the calling thread, without a clock. Not while started.
    /// Guarded against failed assertions like the thread's ticks.
    void advance(int ticks);

    /// Ends the thread if there is one, and sends the safe state. May be called twice.
    void stop() noexcept;

    /// Ends the thread temporarily, if there is one: the amplifiers hold the last command, and the
    /// caller may use the device. Returns whether the thread was running.
    bool pause() noexcept;

    /// Continues with the options of `start` and the present state.
    void resume();

    /// While paused, somebody else used the device, see ServoLoop::expect_gap.
    void expect_gap() noexcept { loop_.expect_gap(); }

    /// Changes the rate from the next tick on, also while running.
    /// @throw InputError as `servo_period_s` and the device do; the rate is then unchanged
    void set_rate(double servo_hz);
    [[nodiscard]] double rate_hz() const { return servo_hz_; }

    /// `ServoSample::clock_s` now; NaN before `start`, and in lockstep.
    [[nodiscard]] double clock_s() const noexcept;

    /// Passes every sample since the last call to `take`, oldest first. Thread of `publish` only.
    template <typename Take> void drain(Take &&take) { samples_.drain(take); }

    /// Samples lost because `drain` came too late.
    [[nodiscard]] std::uint64_t lost_samples() const { return samples_.lost(); }

    /// A second queue for one more reader, filled while `feed_recorder` is on. Made by the first
    /// call of either: it holds 40 MB, and most sessions record nothing.
    [[nodiscard]] SampleRing<ServoSample> &record_ring();
    void feed_recorder(bool on);

    [[nodiscard]] double period_s() const { return loop_.period_s(); }

    /// While the servo's own thread is not running.
    [[nodiscard]] const WindingObservers &observers() const { return loop_.observers(); }

    /// Whether the servo's own thread is not running.
    [[nodiscard]] bool is_at_rest() const { return !thread_.joinable(); }

private:
    using Clock = std::chrono::steady_clock;

    void run() noexcept;
    template <typename Ticks> [[nodiscard]] bool have_completed(const Ticks &ticks) noexcept;
    std::vector<std::string> run_on_a_thread();
    [[nodiscard]] const ServoInputs &changed_by_schedule(const ServoInputs &published) noexcept;
    void hand_over(const ServoSample &sample) noexcept;

    double servo_hz_;
    ServoThread how_; ///< options of the thread
    bool has_started_ = false;
    std::optional<Clock::time_point> origin_; ///< of the samples' clock
    ServoLoop loop_;
    LatestValue<ServoInputs> inputs_;
    ServoInputs changed_inputs_;
    ServoSample last_;
    bool has_last_ = false;
    SampleRing<ServoSample> samples_;
    std::optional<SampleRing<ServoSample>> record_samples_;
    std::atomic<bool> recording_{false};

    std::atomic<bool> stopping_{false};
    bool stopped_ = false;
    std::thread thread_;
    std::optional<ShortIdle> short_idle_;
};

} // namespace springdrive::servo
