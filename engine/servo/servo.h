// The servo: a loop on its own thread and clock, or in lockstep with whoever calls it.
//
//   window ── publish(ServoInputs) ──► mailbox ──► ┌─ thread: exchange, update ─┐
//   window ◄── drain(ServoSample)  ◄── ring    ◄── └────────────────────────────┘
//
// Nothing between the two threads waits. Destroying the servo stops it; the last thing that the
// device hears is the safe state.
#pragma once

#include "base/latest_value.h"
#include "base/sample_ring.h"
#include "engine/servo/duration_histogram.h"
#include "engine/servo/servo_loop.h"

#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

namespace springdrive {

/// T = 1/rate [s].
/// @throw InputError for a rate that is not finite or not from 250 to 10,000 Hz.
[[nodiscard]] double servo_period_s(double servo_hz);

/// How well the servo keeps its time, since its start.
struct ServoStatistics {
    struct Duration {
        double mean_s = 0.0;
        double p50_s = 0.0;
        double p99_s = 0.0;
        double longest_s = 0.0;
    };
    std::uint64_t ticks = 0;
    std::uint64_t skipped = 0; ///< deadlines passed over because a tick was still running
    Duration period;           ///< from the start of a tick to the next one's
    Duration lateness;         ///< from a tick's deadline to its start: the jitter
    Duration compute;          ///< from the device's answer to the next command
    Duration exchange;         ///< what the device took
};

class Servo {
public:
    /// @throw InputError as `servo_period_s` does.
    Servo(HapticDevice &device, double servo_hz);
    ~Servo() { stop(); }
    Servo(const Servo &) = delete;
    Servo &operator=(const Servo &) = delete;

    /// New inputs from the next tick on. One thread at a time.
    void publish(const ServoInputs &inputs) noexcept { inputs_.publish(inputs); }

    /// Runs from now on a thread of its own, with real-time priority where allowed. Returns a
    /// remark for each thing that the system refused.
    std::vector<std::string> start();

    /// Runs `ticks` ticks now, on the calling thread, without a clock. Not while started.
    void advance(int ticks);

    /// Ends the thread if there is one, and sends the safe state. Harmless twice.
    void stop() noexcept;

    /// Hands every sample since the last call to `take`, oldest first. The thread of `publish`.
    template <typename Take> void drain(Take &&take) { samples_.drain(take); }

    /// Samples lost because `drain` came too late.
    [[nodiscard]] std::uint64_t lost_samples() const { return samples_.lost(); }

    /// At most a tenth of a second old while running. The thread of `publish`.
    [[nodiscard]] const ServoStatistics &statistics() noexcept { return statistics_.latest(); }

    [[nodiscard]] double period_s() const { return loop_.period_s(); }

private:
    using Clock = std::chrono::steady_clock;

    void run() noexcept;
    void tick(bool by_the_clock) noexcept;
    void publish_statistics() noexcept;

    ServoLoop loop_;
    LatestValue<ServoInputs> inputs_;
    SampleRing<ServoSample> samples_;
    LatestValue<ServoStatistics> statistics_;

    std::atomic<bool> stopping_{false};
    bool stopped_ = false;
    std::thread thread_;

    // Of the thread that ticks.
    Clock::time_point last_start_{};
    DurationHistogram period_;
    DurationHistogram lateness_;
    DurationHistogram compute_;
    DurationHistogram exchange_;
    std::uint64_t ticks_ = 0;
    std::uint64_t skipped_ = 0;
    std::uint64_t ticks_a_report_ = 1;
};

} // namespace springdrive
