#include "engine/servo/servo.h"

#include "base/input_error.h"
#include "engine/servo/real_time.h"

#include <cmath>
#include <ctime>
#include <future>
#include <sstream>
#include <utility>

namespace springdrive {

namespace {

/// At the fastest rate the window may fall 1.6 s behind before samples are lost.
constexpr std::size_t kRingCapacity = 16'384;

constexpr double kSlowest_hz = 250.0;
constexpr double kFastest_hz = 10'000.0;

template <typename Duration> double seconds(Duration duration) {
    return std::chrono::duration<double>(duration).count();
}

ServoStatistics::Duration summary(const DurationHistogram &histogram) {
    return {histogram.mean_s(), histogram.quantile_s(0.5), histogram.quantile_s(0.99),
            histogram.longest_s()};
}

/// std::this_thread::sleep_until sleeps relative to now when the clock is not the system's own;
/// this one keeps the absolute deadline.
void sleep_until(std::chrono::steady_clock::time_point deadline) {
    const auto since_epoch =
        std::chrono::duration_cast<std::chrono::nanoseconds>(deadline.time_since_epoch()).count();
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
    : loop_(device, servo_period_s(servo_hz)), samples_(kRingCapacity),
      ticks_a_report_(static_cast<std::uint64_t>(std::ceil(0.1 * servo_hz))) {}

std::vector<std::string> Servo::start() {
    std::promise<std::vector<std::string>> remarks;
    std::future<std::vector<std::string>> answer = remarks.get_future();
    thread_ = std::thread([this, remarks = std::move(remarks)]() mutable {
        remarks.set_value(make_this_thread_real_time());
        run();
    });
    return answer.get();
}

void Servo::run() noexcept {
    const auto period = std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(loop_.period_s()));
    Clock::time_point deadline = Clock::now() + period;
    while (!stopping_.load(std::memory_order_relaxed)) {
        sleep_until(deadline);
        const Clock::time_point now = Clock::now();
        lateness_.add(seconds(now - deadline));
        tick(true);
        deadline += period;
        // A late tick is never run twice in a row to catch up: what it missed is passed over.
        for (const Clock::time_point end = Clock::now(); deadline < end; deadline += period) {
            ++skipped_;
        }
    }
}

void Servo::advance(int ticks) {
    for (int i = 0; i < ticks; ++i) {
        tick(false);
    }
    publish_statistics();
}

void Servo::tick(bool by_the_clock) noexcept {
    const Clock::time_point start = Clock::now();
    const DeviceState state = loop_.exchange();
    const Clock::time_point answered = Clock::now();
    ServoSample sample = loop_.update(state, inputs_.latest());
    const Clock::time_point end = Clock::now();

    exchange_.add(seconds(answered - start));
    compute_.add(seconds(end - answered));
    if (by_the_clock) {
        if (ticks_ > 0) {
            sample.period_s = seconds(start - last_start_);
            period_.add(sample.period_s);
        }
        sample.exchange_s = seconds(answered - start);
        sample.compute_s = seconds(end - answered);
    }
    last_start_ = start;
    samples_.push(sample);
    if (++ticks_ % ticks_a_report_ == 0) {
        publish_statistics();
    }
}

void Servo::publish_statistics() noexcept {
    statistics_.publish({ticks_, skipped_, summary(period_), summary(lateness_), summary(compute_),
                         summary(exchange_)});
}

void Servo::stop() noexcept {
    if (thread_.joinable()) {
        stopping_.store(true, std::memory_order_relaxed);
        thread_.join();
        publish_statistics();
    }
    if (!std::exchange(stopped_, true)) {
        loop_.stop();
    }
}

} // namespace springdrive
