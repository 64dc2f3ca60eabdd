// One servo tick: the signal path of DESIGN section 3, from encoder counts to motor voltages.
// Knows no clock and no thread; `Servo` gives it both.
#pragma once

#include "device/haptic_device.h"
#include "engine/contact/proxy.h"
#include "engine/control/velocity_filter.h"
#include "engine/servo/safety_monitor.h"
#include "engine/servo/servo_inputs.h"
#include "engine/servo/servo_sample.h"

namespace springdrive {

/// Remembers between ticks only the velocity filter, the proxy, the safety monitor and the command
/// that the next exchange will carry.
class ServoLoop {
public:
    /// @param device  must outlive the loop, which is the only one to talk to it
    ServoLoop(HapticDevice &device, double period_s);

    /// First half of a tick: sends the last command, fetches the newest measurement. RT-safe.
    DeviceState exchange() noexcept { return device_.exchange(command_); }

    /// Second half: from the measurement to the next command. RT-safe. All that it found is in the
    /// sample returned.
    ServoSample update(const DeviceState &state, const ServoInputs &inputs) noexcept;

    /// Sends the safe state, once and for all: the last thing a device hears. RT-safe.
    void stop() noexcept;

    [[nodiscard]] double period_s() const { return period_s_; }
    [[nodiscard]] const HapticDevice &device() const { return device_; }

private:
    void take(const ServoInputs &inputs) noexcept;
    void approach(const Tuning &wanted) noexcept;
    [[nodiscard]] Configuration configuration(const DeviceState &state) noexcept;
    [[nodiscard]] double alpha(double bound, const ServoInputs &inputs) const noexcept;
    [[nodiscard]] Contact touch(const Vector3 &tip_m, const ServoInputs &inputs) noexcept;
    [[nodiscard]] DeviceCommand law(const Configuration &now, const ServoInputs &inputs,
                                    ServoSample &sample) noexcept;

    HapticDevice &device_;
    double period_s_;
    Vector3 k_T_;
    Vector3 relative_stiffness_;
    double rad_per_count_;

    Tuning tuning_;              ///< in force: on its way to what was last asked for
    double velocity_pole_ = 0.0; ///< e^(−λT) of `tuning_`
    VelocityFilter velocity_filter_;
    Proxy proxy_;
    SafetyMonitor safety_;
    DeviceCommand command_;
    std::uint64_t tick_ = 0;
    std::uint32_t scene_id_ = 0;
    std::uint32_t reset_count_ = 0;
};

} // namespace springdrive
