#include "engine/servo/servo.h"

#include "base/assertions.h"
#include "base/input_error.h"
#include "engine/servo/servo_timing.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <future>
#include <limits>
#include <utility>

namespace springdrive::servo {

namespace {

/// At the maximum rate the window may lag by 1.6 s before its plots lose samples, and a disk may
/// stall for 3.2 s before a record loses samples.
constexpr std::size_t kWindowRing = 16'384;
constexpr std::size_t kRecordRing = 32'768;

std::int64_t nanoseconds(std::chrono::steady_clock::duration duration) {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(duration).count();
}

double seconds(std::chrono::steady_clock::duration duration) {
    return std::chrono::duration<double>(duration).count();
}

/// How long a simulated device keeps running without a heartbeat from the window: well within the
/// monitor's limit, so that a slow window causes no trip.
class WindowTimeout {
public:
    explicit WindowTimeout(const device::HapticDevice &device)
        : waits_(device.clock() == device::DeviceClock::servo),
          limits_(limits_of(device.description())) {}

    [[nodiscard]] bool is_over(const ServoInputs &inputs, double now_s) noexcept {
        constexpr double kShare = 0.5;
        if (inputs.heartbeat != heartbeat_ || inputs.heartbeat == 0) {
            heartbeat_ = inputs.heartbeat;
            beat_s_ = now_s;
        }
        return waits_ &&
               now_s - beat_s_ > kShare * lowered(limits_, inputs.limits).window_silence_s;
    }

private:
    bool waits_;
    SafetyLimits limits_;
    std::uint32_t heartbeat_ = 0;
    double beat_s_ = 0.0;
};

/// std::this_thread::sleep_until may convert the deadline to a relative time; this function sleeps
/// until the absolute deadline.
void sleep_until(std::chrono::steady_clock::time_point deadline) {
    const std::int64_t since_epoch = nanoseconds(deadline.time_since_epoch());
    timespec when{};
    when.tv_sec = static_cast<time_t>(since_epoch / 1'000'000'000);
    when.tv_nsec = static_cast<long>(since_epoch % 1'000'000'000);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &when, nullptr) != 0) {
        // Interrupted by a signal: sleep again.
    }
}

} // namespace

double servo_period_s(double servo_hz) {
    if (!(servo_hz >= kMinRate_hz && servo_hz <= kMaxRate_hz)) {
        throw InputError(fmt::format("the servo rate is {:g} Hz; it must be from {:g} to {:g} Hz",
                                     servo_hz, kMinRate_hz, kMaxRate_hz));
    }
    return 1.0 / servo_hz;
}

Servo::Servo(device::HapticDevice &device, double servo_hz)
    : servo_hz_(servo_hz), loop_(device, servo_period_s(servo_hz)), samples_(kWindowRing) {}

SampleRing<ServoSample> &Servo::record_ring() {
    if (!record_samples_) {
        record_samples_.emplace(kRecordRing);
    }
    return *record_samples_;
}

void Servo::feed_recorder(bool on) {
    if (on) {
        static_cast<void>(record_ring());
    }
    recording_.store(on, std::memory_order_release);
}

std::vector<std::string> Servo::start(const ServoThread &how) {
    how_ = how;
    has_started_ = true;
    origin_ = Clock::now();
    short_idle_.emplace(); // before the first deadline
    std::vector<std::string> warnings = run_on_a_thread();
    how_.on_start = nullptr;
    if (!short_idle_->warning().empty()) {
        warnings.push_back(short_idle_->warning());
    }
    return warnings;
}

std::vector<std::string> Servo::run_on_a_thread() {
    std::promise<std::vector<std::string>> promise;
    std::future<std::vector<std::string>> answer = promise.get_future();
    stopping_.store(false, std::memory_order_relaxed);
    thread_ = std::thread([this, how = how_, promise = std::move(promise)]() mutable {
        promise.set_value(make_this_thread_real_time(how.cpu));
        if (how.on_start) {
            how.on_start();
        }
        run();
    });
    return answer.get();
}

/// Runs the ticks. False if an assertion failed; the device then brakes.
template <typename Ticks> bool Servo::have_completed(const Ticks &ticks) noexcept {
    return run_guarded(ticks, [this](const AssertionFailure &failure) { loop_.fail(failure); });
}

void Servo::run() noexcept {
    const Clock::time_point begin = Clock::now();
    const Clock::time_point origin = *origin_;
    Clock::time_point last_start = begin;
    bool is_first = true;
    Deadlines deadlines(servo_hz_);
    WindowTimeout timeout(loop_.device());
    std::uint32_t waited = 0; // deadlines at which a simulated device waited for the window
    const auto tick = [&] {
        const std::int64_t due_ns = deadlines.next_ns();
        sleep_until(begin + std::chrono::nanoseconds(due_ns));
        const Clock::time_point start = Clock::now();
        deadlines.begin(nanoseconds(start - begin));
        const ServoInputs &inputs = inputs_.latest();
        if (timeout.is_over(inputs, seconds(start - begin))) {
            waited += 1 + deadlines.missed();
            deadlines.end(nanoseconds(Clock::now() - begin));
            return;
        }
        const device::Measurement measured = loop_.read();
        const Clock::time_point answered = Clock::now();
        ServoSample sample =
            loop_.update(measured, changed_by_schedule(inputs),
                         {deadlines.missed() + waited, deadlines.missed_in_a_row() + waited});
        const Clock::time_point found = Clock::now();
        loop_.write();
        const Clock::time_point end = Clock::now();
        sample.clock_s = seconds(start - origin);
        sample.lateness_s = seconds(start - begin) - 1e-9 * static_cast<double>(due_ns);
        if (!is_first) {
            sample.period_s = seconds(start - last_start);
        }
        sample.read_s = seconds(answered - start);
        sample.compute_s = seconds(found - answered);
        sample.write_s = seconds(end - found);
        last_start = start;
        is_first = false;
        waited = 0;
        hand_over(sample);
        deadlines.end(nanoseconds(Clock::now() - begin));
    };
    const auto until_stopped = [&] {
        while (!stopping_.load(std::memory_order_relaxed)) {
            tick();
        }
    };
    if (!have_completed(until_stopped)) {
        deadlines.end(nanoseconds(Clock::now() - begin)); // of the abandoned tick
        // From here on ticks only brake. If one fails again, the thread commands braking and ends.
        static_cast<void>(have_completed(until_stopped));
    }
}

void Servo::advance(int ticks) {
    int done = 0;
    const auto the_others = [&] {
        for (; done < ticks; ++done) {
            hand_over(loop_.tick(changed_by_schedule(inputs_.latest())));
        }
    };
    if (!have_completed(the_others)) {
        static_cast<void>(have_completed(the_others)); // these only brake
    }
}

bool Servo::pause() noexcept {
    if (!thread_.joinable()) {
        return false;
    }
    stopping_.store(true, std::memory_order_relaxed);
    thread_.join();
    return true;
}

void Servo::resume() {
    if (has_started_ && !stopped_ && !thread_.joinable()) {
        static_cast<void>(run_on_a_thread());
    }
}

void Servo::set_rate(double servo_hz) {
    const double period_s = servo_period_s(servo_hz);
    const bool ran = pause();
    try {
        loop_.set_period(period_s);
        servo_hz_ = servo_hz;
    } catch (...) {
        if (ran) {
            resume();
        }
        throw;
    }
    if (ran) {
        resume();
    }
}

double Servo::clock_s() const noexcept {
    return origin_ ? seconds(Clock::now() - *origin_) : std::numeric_limits<double>::quiet_NaN();
}

const ServoInputs &Servo::changed_by_schedule(const ServoInputs &published) noexcept {
    if (published.schedule == nullptr || !has_last_) {
        return published;
    }
    changed_inputs_ = published;
    published.schedule->update(last_, changed_inputs_);
    return changed_inputs_;
}

void Servo::hand_over(const ServoSample &sample) noexcept {
    last_ = sample;
    has_last_ = true;
    samples_.push(sample);
    if (recording_.load(std::memory_order_acquire)) {
        record_samples_->push(sample);
    }
}

void Servo::stop() noexcept {
    pause();
    short_idle_.reset();
    if (!std::exchange(stopped_, true)) {
        loop_.stop();
    }
}

} // namespace springdrive::servo
