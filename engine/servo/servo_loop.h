// One servo tick, from encoder counts to motor voltages: docs/design.md, "One servo tick".
// Independent of clock and thread, which `Servo` provides.
#pragma once

#include "device/core/haptic_device.h"
#include "engine/contact/proxy/proxy.h"
#include "engine/control/drive_gains.h"
#include "engine/control/haptic_law.h"
#include "engine/control/velocity_filter.h"
#include "engine/servo/bumpless_transfer.h"
#include "engine/servo/safety_monitor.h"
#include "engine/servo/servo_inputs.h"
#include "engine/servo/servo_sample.h"
#include "engine/servo/winding_observers.h"

#include <limits>
#include <optional>

namespace springdrive::servo {

/// Timing of a tick by the host's clock; zero in lockstep, which has no clock.
struct TickTiming {
    std::uint32_t missed_deadlines = 0; ///< skipped just before this tick
    std::uint32_t missed_in_a_row = 0;  ///< including those before the preceding late ticks
};

/// State between ticks: the velocity filter, the proxy, the safety monitor, the last inputs and the
/// transfer to them, the last measurement, and the active command.
///
/// The time between two measurements is taken from the device's clock. A device on the servo's
/// clock waits for the servo, so a late host misses none of its periods. For a device that does not
/// wait, the monitor checks the missed deadlines.
class ServoLoop {
public:
    /// @param device  must outlive the loop, and be used by nothing else
    ServoLoop(device::HapticDevice &device, double period_s);

    // A tick in three parts, each RT-safe.
    [[nodiscard]] device::Measurement read() noexcept {
        tick_begun_ = tick_;
        return device_.read();
    }

    /// Computes the command for a measurement. All intermediate results are in the returned sample.
    /// Without a new measurement the active command is held as long as the monitor allows.
    ServoSample update(const device::Measurement &measured, const ServoInputs &inputs,
                       const TickTiming &timing = {}) noexcept;

    void write() noexcept { device_.write(command_); }

    /// All three parts.
    ServoSample tick(const ServoInputs &inputs, const TickTiming &timing = {}) noexcept {
        const ServoSample sample = update(read(), inputs, timing);
        write();
        return sample;
    }

    /// Call when an assertion failed in one of these: commands the safe state immediately. From
    /// then on ticks only measure and brake; law, surface and requests are ignored. The caller must
    /// guard the loop by `run_guarded`; otherwise a failed assertion ends the program. RT-safe.
    void fail(const AssertionFailure &failure) noexcept;

    /// Sets T of loop and device from the next tick on, and takes over the device's delay; keeps
    /// the state. Not on the servo's thread.
    /// @throw InputError for a period that the device does not support
    void set_period(double period_s);

    /// Measurements between the last and the next one went to somebody else: their time has
    /// passed, but the servo missed no period of a device on its clock. Not on the servo's thread.
    void expect_gap() noexcept { expects_gap_ = true; }

    /// Sends the safe state as the last command to the device. RT-safe.
    void stop() noexcept;

    [[nodiscard]] double period_s() const { return period_s_; }
    [[nodiscard]] const device::HapticDevice &device() const { return device_; }
    [[nodiscard]] const WindingObservers &observers() const { return observers_; }

private:
    /// Device time since the last new measurement.
    struct Passed {
        double since_last_s = 0.0; ///< between the last two new measurements
        std::uint32_t missed_periods = 0;
        std::uint32_t missed_in_a_row = 0; ///< for the monitor's check
    };

    void take_orders(const ServoInputs &inputs) noexcept;
    void take(const ServoInputs &inputs) noexcept;
    [[nodiscard]] Passed passed(const device::Measurement &measured,
                                const TickTiming &timing) noexcept;
    [[nodiscard]] ServoSample begin_sample(const device::Measurement &measured,
                                           const TickTiming &timing) const noexcept;
    [[nodiscard]] ServoSample hold(const device::Measurement &measured, const ServoInputs &inputs,
                                   const TickTiming &timing) noexcept;
    [[nodiscard]] ServoSample brake(const device::Measurement &measured, const ServoInputs &inputs,
                                    const TickTiming &timing) noexcept;
    void finish(const device::Measurement &measured, ServoSample &sample) noexcept;
    [[nodiscard]] control::Configuration sense(const device::Measurement &measured,
                                               double since_last_s) noexcept;
    void observe_motors(const device::Measurement &measured, const Vector3 &theta_rad,
                        const Passed &since) noexcept;
    void note_motion(const control::Configuration &now, ServoSample &sample) const noexcept;
    [[nodiscard]] contact::Contact touch(const Vector3 &tip_m) noexcept;
    [[nodiscard]] std::optional<control::LawOutcome>
    unchanged_law(control::VelocityFilter filter, double since_last_s, const Vector3 &theta_rad,
                  const contact::Contact &contact) const noexcept;
    [[nodiscard]] control::LawOutcome law(const control::Configuration &now,
                                          ServoSample &sample) const noexcept;
    [[nodiscard]] Vector3 spring_force_N(const control::Configuration &now,
                                         const control::Tuning &tuning,
                                         const control::LawOutcome &found) const noexcept;
    [[nodiscard]] Observation observation(const control::Configuration &now,
                                          const control::LawOutcome &found,
                                          const std::optional<control::LawOutcome> &unchanged,
                                          const Passed &since, const device::Measurement &measured,
                                          const ServoSample &sample) const noexcept;
    [[nodiscard]] SafetyOrders orders() const noexcept;
    [[nodiscard]] double lag_s() const noexcept {
        return period_s_ * (0.5 + device_.delay_periods());
    }

    device::HapticDevice &device_;
    double period_s_;
    double time_base_s_ = 0.0;         ///< the servo's time when its period was last set
    std::uint64_t time_base_tick_ = 0; ///< the tick at that time
    control::HapticLaw law_;

    ServoInputs inputs_;        ///< the last valid ones
    BumplessTransfer transfer_; ///< to the settings last requested
    control::VelocityFilter velocity_filter_;
    WindingObservers observers_;
    control::ObservedMotors motors_;                                ///< of this tick
    Vector3 spring_A_{Vector3::Zero()};                             ///< of the last law
    Vector3 trim_V_{Vector3::Zero()};                               ///< the same, along i*
    double alpha_before_ = std::numeric_limits<double>::infinity(); ///< see control::AlphaSources
    control::HeldForce held_force_;
    contact::Proxy proxy_;
    std::uint32_t scene_id_ = 0;
    const contact::HapticSurface *surface_ = nullptr;
    std::optional<Vector3> fixed_x0_m_;
    bool scene_is_new_ = false;
    SafetyMonitor safety_;
    device::DeviceCommand command_ = device::DeviceCommand::braking(); ///< active
    device::Measurement measured_;                                     ///< the last new one
    contact::Contact contact_;                                         ///< at that measurement
    bool has_measured_ = false;
    std::uint32_t skipped_in_a_row_ = 0; ///< periods of a device on the servo's clock
    bool expects_gap_ = false;
    std::uint32_t held_ticks_ = 0; ///< since the last new measurement
    std::uint64_t tick_ = 0;
    std::uint64_t tick_begun_ = 0; ///< may be abandoned at any point by an assertion
};

} // namespace springdrive::servo
