// Imitates hardware: a device that does not wait for the servo. Its clock is the computer's, and
// its plant advances by the number of periods that have passed.
#pragma once

#include "device/core/haptic_device.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace springdrive::testing {

class OwnClockDevice final : public device::ForwardingDevice {
public:
    /// @param max_periods  by which the plant advances at most in one read; after a longer gap it
    ///                      lags
    OwnClockDevice(device::HapticDevice &device, double period_s, int max_periods = 100)
        : device::ForwardingDevice(device), period_s_(period_s), max_periods_(max_periods) {}

    [[nodiscard]] device::DeviceClock clock() const override { return device::DeviceClock::own; }
    [[nodiscard]] device::Measurement read() noexcept override {
        const double now_s = std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
        const double passed = started_ ? std::round((now_s - last_s_) / period_s_) : 1.0;
        last_s_ = now_s;
        started_ = true;
        device::Measurement measured = device::ForwardingDevice::read();
        for (int i = 1; i < std::min(static_cast<int>(std::min(passed, 1e6)), max_periods_); ++i) {
            measured = device::ForwardingDevice::read();
        }
        measured.time_s = now_s;
        return measured;
    }

private:
    using Clock = std::chrono::steady_clock;

    double period_s_;
    int max_periods_;
    bool started_ = false;
    double last_s_ = 0.0;
};

} // namespace springdrive::testing
