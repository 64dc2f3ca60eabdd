// The last stage before the motors. Every command passes through it; nothing switches it off.
//
//   law ──► reject what is not finite ──► limits ──► start-up ramp ──► device
//
// A trip latches: the device gets the safe state (braking, e_W = 0 and R̂ = 0) until a deliberate
// reset. Limits come from the device file; that of R̂ moves with what is known of each winding's
// temperature, see winding_guard.h.
#pragma once

#include "device/haptic_device.h"
#include "engine/control/motion_control.h"
#include "engine/servo/winding_guard.h"

#include <array>
#include <cstdint>
#include <string>

namespace springdrive {

enum class SafetyState : std::uint8_t { starting, running, tripped };

enum class TripCause : std::uint8_t {
    none,
    emergency_stop,
    device_lost,
    not_finite,
    tip_speed,
    tip_force,
    current,
    winding_temperature,
};

struct SafetyStatus {
    SafetyState state = SafetyState::starting;
    TripCause cause = TripCause::none;
    double measured = 0.0; ///< what crossed the limit, in the limit's unit; 0 where none did
    double limit = 0.0;
    double ramp = 0.0; ///< 0 to 1, share of the command that passes while starting
};

/// What the monitor knows of one winding, and made of it in its last tick.
struct WindingStatus {
    double least_C = 0.0;         ///< its temperature is not lower,
    double greatest_C = 0.0;      ///< nor higher
    double R_hat_limit_Ohm = 0.0; ///< the largest R̂ that it can bear
    bool is_limited = false;      ///< whether more than that was asked for
};

/// Why it tripped, with the numbers: "winding current 5.57 A, limit 5.50 A". Allocates.
[[nodiscard]] std::string description(const SafetyStatus &status);

class SafetyMonitor {
public:
    SafetyMonitor(DeviceDescription device, double period_s);

    /// What one tick shows of the machine.
    struct Measurement {
        DeviceHealth health = DeviceHealth::ok;
        Vector3 tip_velocity_m_per_s{Vector3::Zero()};
        Vector3 tip_force_N{Vector3::Zero()}; ///< rendered, J⁻ᵀ k_T i
        Vector3 current_A{Vector3::Zero()};
        bool all_finite = true; ///< of everything else on the signal path
    };

    /// The command that may go to the device. RT-safe.
    DeviceCommand pass(const DeviceCommand &wanted, const Measurement &measured,
                       bool emergency_stop) noexcept;

    /// Leaves a trip and ramps up again, unless its cause is still there: then the next `pass`
    /// trips anew. RT-safe.
    void reset() noexcept;

    [[nodiscard]] const SafetyStatus &status() const { return status_; }
    [[nodiscard]] const std::array<WindingStatus, 3> &windings() const { return winding_; }

private:
    void watch_windings(const Vector3 &current_A) noexcept;
    void trip(TripCause cause, double measured, double limit) noexcept;
    void check(const DeviceCommand &wanted, const Measurement &measured,
               bool emergency_stop) noexcept;

    DeviceDescription device_;
    double period_s_;
    std::array<WindingGuard, 3> guard_;
    std::array<WindingStatus, 3> winding_{};
    int ticks_above_force_limit_ = 0;
    SafetyStatus status_;
};

} // namespace springdrive
