// One servo tick, from encoder counts to motor voltages: docs/design.md, "One servo tick".
// Knows no clock and no thread; `Servo` gives it both.
#pragma once

#include "device/core/haptic_device.h"
#include "engine/contact/proxy/proxy.h"
#include "engine/control/haptic_law.h"
#include "engine/control/velocity_filter.h"
#include "engine/servo/bumpless_transfer.h"
#include "engine/servo/safety_monitor.h"
#include "engine/servo/servo_inputs.h"
#include "engine/servo/servo_sample.h"

#include <optional>

namespace springdrive::servo {

/// What the host's clock has to say of a tick; nothing in lockstep, where there is none.
struct TickTiming {
    std::uint32_t missed_deadlines = 0; ///< passed over just before this tick
    std::uint32_t missed_in_a_row = 0;  ///< with those before the late ticks just before
};

/// Remembers between ticks only the velocity filter, the proxy, the safety monitor, what it was
/// last told and how far it has followed, what was last measured, and the command in force.
///
/// The time between two measurements is what the device's clock says. One that keeps the servo's
/// clock waits for it: a host that comes late has missed nothing of it. Of one that does not wait,
/// missed deadlines are the monitor's business.
class ServoLoop {
public:
    /// @param device  must outlive the loop, which is the only one to talk to it
    ServoLoop(device::HapticDevice &device, double period_s);

    // A tick in three parts, each RT-safe.
    [[nodiscard]] device::Measurement read() noexcept {
        tick_begun_ = tick_;
        return device_.read();
    }

    /// From the measurement to the command that answers it. All that it found is in the sample
    /// returned. Where nothing new was measured the command in force stands, as long as the monitor
    /// lets it.
    ServoSample update(const device::Measurement &measured, const ServoInputs &inputs,
                       const TickTiming &timing = {}) noexcept;

    void write() noexcept { device_.write(command_); }

    /// All three.
    ServoSample tick(const ServoInputs &inputs, const TickTiming &timing = {}) noexcept {
        const ServoSample sample = update(read(), inputs, timing);
        write();
        return sample;
    }

    /// An assertion failed in one of these: commands the safe state at once, whatever was going on.
    /// From then on ticks measure and brake; law, surface and orders are not looked at any more.
    /// Whoever runs the loop has to see to it, see `run_guarded`; else the program ends. RT-safe.
    void fail(const AssertionFailure &failure) noexcept;

    /// T from the next tick on, of loop and device; all that is remembered stays. Not on the
    /// servo's thread.
    /// @throw InputError for a period that the device cannot keep
    void set_period(double period_s);

    /// Sends the safe state, once and for all: the last thing a device hears. RT-safe.
    void stop() noexcept;

    [[nodiscard]] double period_s() const { return period_s_; }
    [[nodiscard]] const device::HapticDevice &device() const { return device_; }

private:
    /// How the device's time went on.
    struct Passed {
        double since_last_s = 0.0; ///< between the last two measurements that told anything
        std::uint32_t missed_periods = 0;
        std::uint32_t missed_in_a_row = 0; ///< that the monitor is to judge
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
                                               double since_last_s, ServoSample &sample) noexcept;
    void note_motion(const control::Configuration &now, ServoSample &sample) const noexcept;
    [[nodiscard]] contact::Contact touch(const Vector3 &tip_m) noexcept;
    [[nodiscard]] std::optional<control::LawOutcome>
    unchanged_law(control::VelocityFilter filter, double since_last_s, const Vector3 &theta_rad,
                  const contact::Contact &contact) const noexcept;
    [[nodiscard]] control::LawOutcome law(const control::Configuration &now,
                                          ServoSample &sample) const noexcept;
    [[nodiscard]] Vector3 spring_force_N(const control::Configuration &now,
                                         const control::Tuning &tuning,
                                         const control::MotorSetPoint &set_point) const noexcept;
    [[nodiscard]] Observation observation(const control::Configuration &now,
                                          const control::LawOutcome &found,
                                          const std::optional<control::LawOutcome> &unchanged,
                                          const Passed &since, const device::Measurement &measured,
                                          const ServoSample &sample) const noexcept;
    [[nodiscard]] SafetyOrders orders() const noexcept;

    device::HapticDevice &device_;
    double period_s_;
    double time_base_s_ = 0.0;         ///< the servo's time when its period was last set,
    std::uint64_t time_base_tick_ = 0; ///< and its tick
    control::HapticLaw law_;

    ServoInputs inputs_;        ///< the last, but for what is no valid wish
    BumplessTransfer transfer_; ///< to what was last asked for
    control::VelocityFilter velocity_filter_;
    contact::Proxy proxy_;
    std::uint32_t scene_id_ = 0;
    const contact::HapticSurface *surface_ = nullptr;
    bool stops_now_ = false; ///< an emergency stop arrived with this tick's inputs
    bool scene_is_new_ = false;
    SafetyMonitor safety_;
    device::DeviceCommand command_ = device::DeviceCommand::braking(); ///< in force
    device::Measurement measured_; ///< the last that told anything
    contact::Contact contact_;     ///< that it was in
    bool has_measured_ = false;
    std::uint32_t skipped_in_a_row_ = 0; ///< periods of a device that keeps the servo's clock
    std::uint32_t held_ticks_ = 0;       ///< since the last measurement that told anything
    std::uint64_t tick_ = 0;
    std::uint64_t tick_begun_ = 0; ///< which an assertion may leave at any point
};

} // namespace springdrive::servo
