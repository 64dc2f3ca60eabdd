// The last stage before the motors. Every command passes through it; nothing switches it off.
//
//   law ──► watch: trip? ──► limits (command_limiter.h) ──► device
//
//   waiting ──tip at rest in free space──► starting ──a second──► running
//      ▲                                       └────────┬────────────┘
//      └──────────── a deliberate reset ──── tripped ◄──┘
//
// Asked to let go of the device it does that as it starts, the other way round: from starting or
// running over releasing, where gains fall as they rose, to waiting, for as long as it is asked.
//
// A trip latches: the device gets the safe state until a deliberate reset. That is braking (e_W = 0
// and R̂ = 0); only a fault of an amplifier itself opens the windings. Limits come from the device
// file, and may be lowered, never raised; that of R̂ moves with what is known of each winding's
// temperature, see winding_guard.h.
#pragma once

#include "device/core/haptic_device.h"
#include "device/core/motor/winding_guard.h"
#include "engine/control/motion_control.h"
#include "engine/servo/command_limiter.h"
#include "engine/servo/energy_observer.h"
#include "engine/servo/rest_watch.h"
#include "engine/servo/safety_limits.h"
#include "engine/servo/safety_status.h"

#include <array>
#include <cstdint>

namespace springdrive::servo {

/// From nothing to the full command.
inline constexpr double kRampTime_s = 1.0;

/// How long e_W may be cut off at its limit, for what force and current would still bear.
inline constexpr double kVoltageTolerated_s = 0.02;

/// Limits of voltage, current and force hold e_W back: lowered or raised again, they move from the
/// device's own to nothing in this time, so that the hand feels no blow.
inline constexpr double kLimitGlide_s = 1.0;

/// What a measurement says of how it came, and its board of itself.
struct Link {
    device::DeviceHealth health = device::DeviceHealth::ok;
    device::Arrival arrival = device::Arrival::fresh;
    device::BoardFaults faults;
    std::uint32_t missed_in_a_row = 0; ///< deadlines, before this tick and the late ones before it
};

/// What one tick shows of the machine and of those who use it.
struct Observation {
    Link link;
    control::Configuration now;
    Vector3 tip_force_N{Vector3::Zero()}; ///< rendered, J⁻ᵀ k_T i
    Vector3 current_A{Vector3::Zero()};
    bool touching = false;
    Vector3 spring_force_N{Vector3::Zero()};   ///< static force (19) of the coupling, as wanted
    Vector3 spring_stretch_m{Vector3::Zero()}; ///< from the tip to the proxy, when touching
    /// The same under the tuning of the last tick: another one only while a tuning changes.
    Vector3 spring_force_before_N{Vector3::Zero()};
    bool scene_is_new = false;        ///< what the spring holds is none of the last tick's
    bool all_finite = true;           ///< of everything else on the signal path
    std::uint32_t missed_periods = 0; ///< since the last measurement that told anything
};

/// What the window asks of the monitor.
struct SafetyOrders {
    SafetyLimits limits = unlowered(); ///< to lower the device's with
    bool emergency_stop = false;
    std::uint32_t heartbeat = 0;
    bool release = false; ///< to let go of the device, at a bounded rate
};

class SafetyMonitor {
public:
    SafetyMonitor(device::DeviceDescription device, double period_s);

    /// T from the next tick on; what is known stays. RT-safe.
    void set_period(double period_s) noexcept;

    /// The command that may go to the device. RT-safe.
    device::DeviceCommand pass(const device::DeviceCommand &wanted, const Observation &seen,
                               const SafetyOrders &orders) noexcept;

    /// The same of a tick that measured nothing new: the command in force stands for as long as
    /// the budget for stale measurements lasts. RT-safe.
    device::DeviceCommand hold(const device::DeviceCommand &in_force, const Link &link,
                               const SafetyOrders &orders) noexcept;

    /// Leaves a trip and starts anew, unless its cause is still there: then the next `pass` trips
    /// again. One by a failed assertion stays: what the servo remembers cannot be trusted. RT-safe.
    void reset() noexcept;

    /// Trips, whatever goes on; returns the safe state. RT-safe.
    [[nodiscard]] device::DeviceCommand fail(const AssertionFailure &failure) noexcept;

    /// Whether what is wanted reaches the motors, at least in part.
    [[nodiscard]] bool lets_pass() const { return servo::lets_pass(status_.state); }

    [[nodiscard]] const SafetyStatus &status() const { return status_; }
    [[nodiscard]] const SafetyLimits &limits() const { return limits_; }
    [[nodiscard]] const ActiveLimits &held_back() const { return held_back_; }
    [[nodiscard]] const std::array<WindingStatus, 3> &windings() const { return winding_; }
    [[nodiscard]] double generated_energy_J() const { return energy_.generated_J(); }

private:
    void approach_limits(const SafetyLimits &wishes) noexcept;
    void watch_windings(const Vector3 &current_A, std::uint32_t missed_periods) noexcept;
    void watch_window(const SafetyOrders &orders, double elapsed_s) noexcept;
    void watch_link(const Link &link, double elapsed_s) noexcept;
    void watch_energy(const Observation &seen) noexcept;
    void trip(TripCause cause, double measured = 0.0, double limit = 0.0) noexcept;
    void trip_above(TripCause cause, double measured, double limit) noexcept;
    void check_link(const Link &link, const SafetyOrders &orders) noexcept;
    void check_clocks(const Link &link) noexcept;
    void check(const device::DeviceCommand &wanted, const Observation &seen,
               const SafetyOrders &orders) noexcept;
    [[nodiscard]] device::DeviceCommand safe_state() const noexcept;
    void check_motion(const Observation &seen) noexcept;
    void check_windings(const Vector3 &current_A) noexcept;
    void check_voltage(const LimitedCommand &passed) noexcept;
    [[nodiscard]] LimitedCommand limited_by_what_stands(const device::DeviceCommand &wanted,
                                                        const control::Configuration &now) noexcept;
    void proceed(bool release) noexcept;

    device::DeviceDescription device_;
    double period_s_;
    SafetyLimits device_limits_;
    SafetyLimits limits_; ///< in force
    std::array<device::WindingGuard, 3> guard_;
    std::array<WindingStatus, 3> winding_{};
    EnergyObserver energy_;
    RestWatch rest_;
    bool knows_tip_ = false;
    Vector3 tip_m_{Vector3::Zero()}; ///< of the last tick
    double cut_off_s_ = 0.0;         ///< how long e_W has been cut off at the supply
    std::uint32_t heartbeat_ = 0;
    double window_silent_s_ = 0.0;
    double stale_s_ = 0.0;               ///< since the last fresh measurement
    std::uint32_t held_ticks_ = 0;       ///< since the last one that told anything
    bool amplifier_is_at_fault_ = false; ///< as its board last said
    ActiveLimits held_back_;
    double force_share_ = 1.0; ///< that the limiter let through in the last tick
    SafetyStatus status_;
};

} // namespace springdrive::servo
