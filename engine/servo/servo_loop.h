// One servo tick: the signal path of DESIGN section 3, from encoder counts to motor voltages.
// Knows no clock and no thread; `Servo` gives it both.
#pragma once

#include "device/haptic_device.h"
#include "engine/contact/proxy.h"
#include "engine/control/haptic_law.h"
#include "engine/control/velocity_filter.h"
#include "engine/servo/change_over.h"
#include "engine/servo/safety_monitor.h"
#include "engine/servo/servo_inputs.h"
#include "engine/servo/servo_sample.h"

#include <optional>

namespace springdrive {

/// What the clock has to say of a tick; nothing in lockstep, where there is none.
struct TickTiming {
    std::uint32_t missed_deadlines = 0; ///< passed over just before this tick
    std::uint32_t missed_in_a_row = 0;  ///< with those before the late ticks just before
};

/// Remembers between ticks only the velocity filter, the proxy, the safety monitor, what it was
/// last told and how far it has followed, and the command that the next exchange will carry.
class ServoLoop {
public:
    /// @param device  must outlive the loop, which is the only one to talk to it
    ServoLoop(HapticDevice &device, double period_s);

    /// First half of a tick: sends the last command, fetches the newest measurement. RT-safe.
    DeviceState exchange() noexcept { return device_.exchange(command_); }

    /// Second half: from the measurement to the next command. RT-safe. All that it found is in the
    /// sample returned. Inputs that are not as they were `sealed` are not looked at, and stop the
    /// device.
    ServoSample update(const DeviceState &state, const ServoInputs &inputs,
                       const TickTiming &timing = {}) noexcept;

    /// Sends the safe state, once and for all: the last thing a device hears. RT-safe.
    void stop() noexcept;

    [[nodiscard]] double period_s() const { return period_s_; }
    [[nodiscard]] const HapticDevice &device() const { return device_; }

private:
    /// The tuning that was in force in the last tick.
    struct Before {
        Tuning tuning;
        double global_alpha_rad2_per_m2 = 0.0;
    };

    void take(const ServoInputs &inputs) noexcept;
    void approach(const Tuning &wanted) noexcept;
    [[nodiscard]] bool in_force(const Before &before) const noexcept;
    [[nodiscard]] Configuration sense(const DeviceState &state, ServoSample &sample) noexcept;
    [[nodiscard]] Configuration configuration(const Vector3 &theta_rad,
                                              double lambda_rad_per_s) const noexcept;
    [[nodiscard]] Contact touch(const Vector3 &tip_m) noexcept;
    [[nodiscard]] std::optional<LawOutcome> unchanged_law(const Before &before,
                                                          const Vector3 &theta_rad,
                                                          const Contact &contact) const noexcept;
    void carry_over(const std::optional<LawOutcome> &unchanged, const Vector3 &e_W_V) noexcept;
    [[nodiscard]] LawOutcome law(const Configuration &now, ServoSample &sample) const noexcept;
    [[nodiscard]] Vector3 spring_force_N(const Configuration &now, const Tuning &tuning,
                                         const MotorSetPoint &set_point) const noexcept;
    void guard(DeviceCommand wanted, const Observation &seen, bool inputs_are_whole,
               ServoSample &sample) noexcept;
    [[nodiscard]] Vector3 within_supply(const Vector3 &e_W_V) const noexcept;

    HapticDevice &device_;
    double period_s_;
    double since_last_s_ = period_s_; ///< from the last measurement to this one
    HapticLaw law_;
    Vector3 supply_V_;
    double greatest_dR_step_Ohm_;

    ServoInputs inputs_; ///< the last that arrived whole
    Tuning tuning_;      ///< in force: on its way to what was last asked for
    VelocityFilter velocity_filter_;
    Proxy proxy_;
    std::uint32_t scene_id_ = 0;
    const HapticSurface *surface_ = nullptr;
    bool stops_now_ = false; ///< an emergency stop arrived with this tick's inputs
    bool scene_is_new_ = false;
    ChangeOver change_over_;
    Vector3 last_e_W_V_{Vector3::Zero()}; ///< as wanted in the last tick
    SafetyMonitor safety_;
    DeviceCommand command_;
    std::uint64_t tick_ = 0;
};

} // namespace springdrive
