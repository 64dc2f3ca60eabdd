// The part of `Session` that lends the device to somebody else.
#include "base/input_error.h"
#include "base/real_time_thread.h"
#include "device/core/bench.h"
#include "device/core/motor/winding_guard.h"
#include "engine/servo/real_time.h"
#include "engine/session/session_parts.h"

#include <nlohmann/json.hpp>

#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <future>
#include <thread>
#include <utility>

namespace springdrive::session {

/// Calls `tick` once a period until it has no more to do.
class Session::Loan {
public:
    Loan(std::function<bool()> tick, double period_s)
        : tick_(std::move(tick)), period_s_(period_s) {}
    ~Loan() { end(); }
    Loan(const Loan &) = delete;
    Loan &operator=(const Loan &) = delete;

    [[nodiscard]] bool has_begun() const { return has_begun_; }
    [[nodiscard]] bool is_over() const { return is_over_.load(std::memory_order_acquire); }
    /// Once it is over, or has ended.
    [[nodiscard]] const std::string &error() const { return error_; }

    void begin(bool on_a_thread, std::optional<int> cpu) {
        has_begun_ = true;
        if (on_a_thread) {
            running_ = run_on_own_heap([this, cpu] {
                static_cast<void>(servo::make_this_thread_real_time(cpu)); // said by the servo
                run();
            });
        }
    }

    /// Without a thread.
    void advance(double frame_s) {
        pending_ticks_ += frame_s / period_s_;
        for (; pending_ticks_ >= 1.0 && !is_over(); pending_ticks_ -= 1.0) {
            tick();
        }
    }

    void end() {
        is_ended_.store(true, std::memory_order_release);
        if (running_.valid()) {
            running_.wait();
        }
    }

private:
    void run() {
        using Clock = std::chrono::steady_clock;
        const auto period =
            std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(period_s_));
        Clock::time_point due = Clock::now();
        while (!is_ended_.load(std::memory_order_acquire) && !is_over()) {
            tick();
            due = std::max(due + period, Clock::now()); // what was missed is not made up for
            std::this_thread::sleep_until(due);
        }
    }

    void tick() {
        try {
            if (tick_()) {
                return;
            }
        } catch (const std::exception &error) {
            error_ = error.what();
        }
        is_over_.store(true, std::memory_order_release);
    }

    std::function<bool()> tick_;
    double period_s_;
    double pending_ticks_ = 0.0;
    bool has_begun_ = false;
    std::string error_;
    std::atomic<bool> is_over_{false};
    std::atomic<bool> is_ended_{false};
    std::future<void> running_;
};

void Session::require_not_lent() const {
    if (loan_) {
        throw InputError("the device is in use by its self-test or calibration; wait until that is "
                         "over, or stop it");
    }
}

void Session::lend_device(std::function<bool()> tick) {
    require_not_lent();
    if (is_exchanging()) {
        throw InputError("the device is being exchanged; wait until that is done");
    }
    if (latest().health == device::DeviceHealth::lost) {
        throw InputError("the device is lost; plug it in again");
    }
    if (latest().safety.state == servo::SafetyState::tripped) {
        throw InputError("the device is stopped: " + servo::description(latest().safety) +
                         "; reset it first");
    }
    loan_error_.clear();
    loan_ = std::make_unique<Loan>(std::move(tick), servo_->period_s());
    release_until_zeroed();
}

void Session::go_on_with_loan(double frame_s) {
    if (!loan_) {
        return;
    }
    if (servo_->is_held_stopped() || loan_->is_over() ||
        latest().safety.state == servo::SafetyState::tripped) {
        take_device_back();
    } else if (loan_->has_begun()) {
        if (servo_->is_in_lockstep()) {
            loan_->advance(frame_s);
        }
    } else if (servo_->halt_if_released()) {
        note(dump({{"device", "lent"}, {"after_tick", latest().tick}}));
        loan_->begin(!servo_->is_in_lockstep(), options_.cpu);
    }
}

void Session::emergency_stop() {
    servo_->emergency_stop();
    take_device_back();
}

/// Ends pulses of a self-test, which go on while its host brakes, by opening the windings.
void Session::end_pulses() {
    constexpr int kMaxTries = 50; // of which some may be lost
    device::HapticDevice &device = device_->device();
    device::Bench *const bench = device.bench();
    const auto answer_by = [&](device::CommandMode mode) {
        device::DeviceCommand command;
        command.mode = mode;
        command.number = device.read().number;
        device.write(command);
    };
    try {
        for (int i = 0; bench != nullptr && i < kMaxTries &&
                        bench->pulses().state == device::PulseState::running;
             ++i) {
            answer_by(device::CommandMode::open);
        }
    } catch (const InputError &) { // which hears nothing, and ends them by itself
    }
    answer_by(device::CommandMode::brake);
}

void Session::take_device_back() {
    if (!loan_) {
        return;
    }
    loan_->end();
    const bool has_begun = loan_->has_begun();
    loan_error_ = loan_->error();
    loan_.reset();
    if (has_begun) {
        end_pulses();
        note(dump({{"device", "back"}, {"after_tick", latest().tick}}));
        released_until_s_ = latest().time_s + kSettling_s;
        release_until_zeroed();
        servo_->resume_watch(device::hottest_motors(description().motor)); // by unseen currents
        servo_->go_on();
    } else {
        release_until_zeroed();
    }
}

} // namespace springdrive::session
