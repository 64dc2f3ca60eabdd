// Decorator that forwards every call to another device; derived classes override what differs.
#pragma once

#include "device/core/haptic_device.h"

#include <memory>
#include <utility>

namespace springdrive::device {

class ForwardingDevice : public HapticDevice {
public:
    /// @param device  must outlive this one
    explicit ForwardingDevice(HapticDevice &device) : device_(&device) {}
    explicit ForwardingDevice(std::unique_ptr<HapticDevice> device)
        : owned_(std::move(device)), device_(owned_.get()) {}

    [[nodiscard]] const DeviceDescription &description() const override {
        return device_->description();
    }
    [[nodiscard]] DeviceClock clock() const override { return device_->clock(); }
    [[nodiscard]] bool can_reach_a_hand() const override { return device_->can_reach_a_hand(); }
    [[nodiscard]] double delay_periods() const override { return device_->delay_periods(); }
    [[nodiscard]] Measurement read() noexcept override { return device_->read(); }
    void write(const DeviceCommand &command) noexcept override { device_->write(command); }
    [[nodiscard]] DeviceIdentity identity() const override { return device_->identity(); }
    [[nodiscard]] std::optional<LinkStatus> link() const override { return device_->link(); }
    [[nodiscard]] Bench *bench() override { return device_->bench(); }
    [[nodiscard]] bool is_zeroed() const override { return device_->is_zeroed(); }
    void set_period(double period_s) override { device_->set_period(period_s); }
    void zero(const Vector3 &theta_rad) override { device_->zero(theta_rad); }
    void close() noexcept override { device_->close(); }
    void reconnect() override { device_->reconnect(); }

private:
    std::unique_ptr<HapticDevice> owned_;
    HapticDevice *device_;
};

} // namespace springdrive::device
