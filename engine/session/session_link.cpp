// The part of `Session` that zeroes a device, and keeps up the connection to one on USB.
#include "base/error_text.h"
#include "engine/session/session_parts.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <string>

namespace springdrive::session {

namespace {

/// Between two looks at a link: whether a lost device is there again, or d has changed.
constexpr double kLook_s = 0.5;

/// A measured d differs by so much from the one in use before the latter is replaced.
constexpr double kDelayTolerance_periods = 0.05;

} // namespace

bool Session::is_zeroed() const { return device_->state() == factory::DeviceState::zeroed; }

void Session::release_until_zeroed() {
    knows_zero_ = is_zeroed();
    const bool is_settling = latest().time_s < released_until_s_;
    servo_->release(is_exchanging() || is_kept_released_ || loan_ || !knows_zero_ || is_settling);
}

void Session::keep_released(bool asked) {
    is_kept_released_ = asked;
    release_until_zeroed();
}

void Session::zero_device(const Vector3 &theta_rad) {
    require_not_lent();
    servo_->paused([&] {
        device_->zero(theta_rad);
        note(dump({{"device", "zeroed"},
                   {"theta_rad", {theta_rad[0], theta_rad[1], theta_rad[2]}},
                   {"after_tick", latest().tick}}));
        released_until_s_ = latest().time_s + kSettling_s;
    });
    release_until_zeroed();
}

void Session::reconnect_device(const std::optional<Vector3> &theta_rad) {
    require_not_lent();
    servo_->paused([&] {
        const Vector3 theta = theta_rad.value_or(latest().theta_rad);
        device_->reconnect();
        if (theta_rad || (device_->has_world() && knows_zero_)) {
            device_->zero(theta);
        }
        servo_->resume_watch({}); // its clock may be another
        note(dump({{"device", "reconnected"}, {"after_tick", latest().tick}}));
    });
    release_until_zeroed();
}

/// The tick that contradicts a zero voids it. Of a lost device `watch_link` says so.
void Session::watch_zero() {
    if (!knows_zero_ || is_zeroed() || latest().health == device::DeviceHealth::lost ||
        latest().safety.state != servo::SafetyState::tripped) {
        return;
    }
    note(dump({{"device", "zero void"}, {"after_tick", latest().tick}}));
    warnings_.add(
        servo::description(latest().safety) +
        ": its zero is void, and no motor is driven until it is zeroed again; reset the "
        "stop, hold the device in its zero pose, and zero it, in the window in tab Plant");
    release_until_zeroed();
}

/// A device that was unplugged is connected again once it is there; its trip stays.
void Session::watch_link() {
    if (released_until_s_ > 0.0 && latest().time_s >= released_until_s_ && !loan_) {
        released_until_s_ = 0.0;
        release_until_zeroed();
    }
    if (device_->has_world() || !has_started_ || is_exchanging() || loan_ || servo_->has_failed()) {
        return;
    }
    if (latest().time_s < next_look_s_) {
        return;
    }
    next_look_s_ = latest().time_s + kLook_s;
    if (latest().health == device::DeviceHealth::ok) {
        adopt_delay();
        return;
    }
    const std::string error = error_text_of([this] { reconnect_device(); });
    if (!error.empty()) {
        warnings_.add(error);
        return;
    }
    const std::string again =
        ++reconnections_ == 1
            ? "the device is connected again"
            : fmt::format("the device is connected again, {} times by now", reconnections_);
    warnings_.add(again +
                  (is_zeroed() ? "; reset the stop to go on" : ", but lost its counts; zero it"));
}

/// While no motor is driven: the servo pauses for it.
void Session::adopt_delay() {
    const double measured = device_->device().delay_periods();
    if (servo::lets_pass(latest().safety.state) || servo_->is_in_lockstep() ||
        std::abs(measured - models_->ground().delay_periods) <= kDelayTolerance_periods) {
        return;
    }
    servo_->paused([&] {
        const std::uint64_t from_tick = servo_->set_rate(servo_->rate_hz()); // the loop's delay
        note(dump({{"delay_periods", measured}, {"from_tick", from_tick}}));
    });
    measure_anew();
}

} // namespace springdrive::session
