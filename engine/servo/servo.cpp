#include "engine/servo/servo.h"

#include "base/input_error.h"
#include "engine/servo/deadlines.h"

#include <cmath>
#include <ctime>
#include <future>
#include <sstream>
#include <utility>

namespace springdrive {

namespace {

/// At the fastest rate the window may fall 1.6 s behind before samples are lost to its plots, and a
/// disk may stall for 3.2 s before they are lost to a record.
constexpr std::size_t kWindowRing = 16'384;
constexpr std::size_t kRecordRing = 32'768;

constexpr double kSlowest_hz = 250.0;
constexpr double kFastest_hz = 10'000.0;

std::int64_t nanoseconds(std::chrono::steady_clock::duration duration) {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(duration).count();
}

double seconds(std::chrono::steady_clock::duration duration) {
    return std::chrono::duration<double>(duration).count();
}

/// std::this_thread::sleep_until sleeps relative to now when the clock is not the system's own;
/// this one keeps the absolute deadline.
void sleep_until(std::chrono::steady_clock::time_point deadline) {
    const std::int64_t since_epoch = nanoseconds(deadline.time_since_epoch());
    timespec when{};
    when.tv_sec = static_cast<time_t>(since_epoch / 1'000'000'000);
    when.tv_nsec = static_cast<long>(since_epoch % 1'000'000'000);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &when, nullptr) != 0) {
        // Woken by a signal: sleep on.
    }
}

} // namespace

double servo_period_s(double servo_hz) {
    if (!(servo_hz >= kSlowest_hz && servo_hz <= kFastest_hz)) {
        std::ostringstream message;
        message << "the servo rate is " << servo_hz << " Hz; it must be from " << kSlowest_hz
                << " to " << kFastest_hz << " Hz";
        throw InputError(message.str());
    }
    return 1.0 / servo_hz;
}

Servo::Servo(HapticDevice &device, double servo_hz)
    : servo_hz_(servo_hz), loop_(device, servo_period_s(servo_hz)), samples_(kWindowRing),
      record_samples_(kRecordRing) {}

std::vector<std::string> Servo::start(const ServoThread &how) {
    std::promise<std::vector<std::string>> promise;
    std::future<std::vector<std::string>> answer = promise.get_future();
    short_idle_.emplace(); // before the first deadline
    thread_ = std::thread([this, how, promise = std::move(promise)]() mutable {
        promise.set_value(make_this_thread_real_time(how.cpu));
        if (how.on_start) {
            how.on_start();
        }
        run();
    });
    std::vector<std::string> remarks = answer.get();
    if (!short_idle_->remark().empty()) {
        remarks.push_back(short_idle_->remark());
    }
    return remarks;
}

void Servo::run() noexcept {
    const Clock::time_point origin = Clock::now();
    Clock::time_point last_start{};
    Deadlines deadlines(servo_hz_);
    while (!stopping_.load(std::memory_order_relaxed)) {
        const std::int64_t due_ns = deadlines.next_ns();
        sleep_until(origin + std::chrono::nanoseconds(due_ns));
        const Clock::time_point start = Clock::now();
        deadlines.begin(nanoseconds(start - origin));

        const DeviceState state = loop_.exchange();
        const Clock::time_point answered = Clock::now();
        ServoSample sample = loop_.update(state, inputs_.latest(),
                                          {deadlines.missed(), deadlines.missed_in_a_row()});
        const Clock::time_point end = Clock::now();
        sample.clock_s = seconds(start - origin);
        sample.lateness_s = sample.clock_s - 1e-9 * static_cast<double>(due_ns);
        if (sample.tick > 0) {
            sample.period_s = seconds(start - last_start);
        }
        sample.exchange_s = seconds(answered - start);
        sample.compute_s = seconds(end - answered);
        last_start = start;
        hand_over(sample);
        deadlines.end(nanoseconds(Clock::now() - origin));
    }
}

void Servo::advance(int ticks) {
    for (int i = 0; i < ticks; ++i) {
        hand_over(loop_.update(loop_.exchange(), inputs_.latest()));
    }
}

void Servo::hand_over(const ServoSample &sample) noexcept {
    samples_.push(sample);
    if (recording_.load(std::memory_order_acquire)) {
        record_samples_.push(sample);
    }
}

void Servo::stop() noexcept {
    if (thread_.joinable()) {
        stopping_.store(true, std::memory_order_relaxed);
        thread_.join();
        short_idle_.reset();
    }
    if (!std::exchange(stopped_, true)) {
        loop_.stop();
    }
}

} // namespace springdrive
