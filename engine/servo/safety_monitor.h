// The last stage before the motors. Every command passes through it; it cannot be switched off.
//
//   law ──► checks: trip? ──► limits (command_limiter.h) ──► device
//
//   waiting ──tip at rest in free space──► starting ──a second──► running
//      ▲                                       └────────┬────────────┘
//      └──────────── a deliberate reset ──── tripped ◄──┘
//
// A request to release the device reverses the start: from starting or running via releasing, where
// the gains ramp down, to waiting, for as long as the request is set. Without a zero of its counts
// the device waits, too, and brakes at once: nobody knows where its motors would push.
//
// A trip latches: the device is in the safe state until a deliberate reset. A requested stop has a
// number, in whatever state it finds the monitor: no reset succeeds until that number is released,
// so that nothing undoes a stop that nobody has seen. The safe state is
// braking (e_W = 0 and R̂ = 0); only a fault of an amplifier itself opens the windings. Limits come
// from the device file, and may be lowered, never raised; that of R̂ follows the estimates of each
// winding's temperature and resistance, see winding_heat.h, and falls at once, until a reset, where
// a winding generates, whatever is believed of it, see winding_balance.h.
#pragma once

#include "base/vector.h"
#include "device/core/haptic_device.h"
#include "device/core/motor/winding_balance.h"
#include "device/core/motor/winding_heat.h"
#include "engine/control/motion_control.h"
#include "engine/servo/command_limiter.h"
#include "engine/servo/motor_consistency.h"
#include "engine/servo/safety_limits.h"
#include "engine/servo/safety_status.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

namespace springdrive::servo {

/// Detects when the tip has been at rest in free space, the condition for enabling the motors.
class RestDetector {
public:
    /// At rest means within kNear_m of one place for kTime_s.
    static constexpr double kNear_m = 1e-3;
    static constexpr double kTime_s = 0.1;

    explicit RestDetector(double period_s) : period_s_(period_s) {}

    void set_period(double period_s) noexcept { period_s_ = period_s; }

    void reset() noexcept { rested_s_ = 0.0; }

    /// Advances by one tick. RT-safe.
    void update(const Vector3 &tip_m, bool touching) noexcept {
        const bool stays = (tip_m - place_m_).norm() <= kNear_m; // false if not finite
        if (touching || !stays) {
            place_m_ = tip_m;
            rested_s_ = 0.0;
            return;
        }
        rested_s_ += period_s_;
    }

    [[nodiscard]] bool is_at_rest() const { return rested_s_ >= kTime_s; }

private:
    double period_s_;
    double rested_s_ = 0.0;
    Vector3 place_m_{Vector3::Zero()};
};

// A passivity observer at the rendered port: the energy that the hand receives from a contact
// beyond what it has put in [Hannaford and Ryu 2002].
//
// Over a tick the tip moves by Δx against the rendered force F, and the motion changes the energy
// of the spring behind the set-point by ΔS. The energy generated is then
//
//   ΔG = F̄·Δx + ΔS,      F̄ the mean of F at start and end
//
// A passive contact has ΔG ≤ 0. The spring's energy is known only from a model, whose errors must
// not cause a trip: the energy counted as stored rises by no more than the hand puts in, and falls
// by no more than the hand receives. Energy that appears in the spring by itself therefore counts
// as generated once the hand receives it. Dissipated energy is soon forgotten, so that a long slide
// against friction does not mask later generation: G decays with kMemory_s, and is never below
// minus the limit.

/// Energy of a spring [J] of whose force only a share is passed on: ½ F·d for the whole force. For
/// less, it is modelled as a spring that yields at the force passed on: linear up to it, constant
/// beyond.
[[nodiscard]] inline double spring_energy_J(const Vector3 &force_N, const Vector3 &stretch_m,
                                            double share) {
    return 0.5 * force_N.dot(stretch_m) * share * (2.0 - share);
}

class EnergyObserver {
public:
    static constexpr double kMemory_s = 0.5;

    explicit EnergyObserver(double period_s) { set_period(period_s); }

    void set_period(double period_s) noexcept { decay_ = std::exp(-period_s / kMemory_s); }

    /// Starts again without memory.
    void reset() noexcept {
        has_previous_ = false;
        generated_J_ = 0.0;
    }

    /// @param stored_J   energy of the spring
    /// @param changed_J  the part due to a change of tuning at this tick, not to motion
    /// RT-safe.
    void update(const Vector3 &tip_m, const Vector3 &force_N, double stored_J, double changed_J,
                double limit_J) noexcept {
        if (has_previous_) {
            const double work_J = 0.5 * (force_N + force_N_).dot(tip_m - tip_m_);
            const double stretched_J = std::clamp(stored_J - changed_J - stored_J_,
                                                  -std::max(0.0, work_J), std::max(0.0, -work_J));
            const double before_J = std::max(0.0, held_J_ + changed_J);
            held_J_ = std::clamp(before_J + stretched_J, 0.0, std::max(0.0, stored_J));
            generated_J_ =
                std::max(decay_ * generated_J_ + work_J + (held_J_ - before_J), -limit_J);
        } else {
            held_J_ = stored_J;
        }
        has_previous_ = true;
        tip_m_ = tip_m;
        force_N_ = force_N;
        stored_J_ = stored_J;
    }

    /// The spring's energy at the last update.
    [[nodiscard]] double stored_J() const { return stored_J_; }
    [[nodiscard]] double generated_J() const { return generated_J_; }

private:
    double decay_ = 0.0;
    bool has_previous_ = false;
    double generated_J_ = 0.0;
    Vector3 tip_m_{Vector3::Zero()};
    Vector3 force_N_{Vector3::Zero()};
    double stored_J_ = 0.0; ///< of the spring, by the model
    double held_J_ = 0.0;   ///< the part of it that the hand put in
};

/// From zero to the full command.
inline constexpr double kRampTime_s = 1.0;

/// How long e_W may be clamped at the voltage limit although the limits of force and current allow
/// it.
inline constexpr double kVoltageTolerated_s = 0.02;

/// How long a board may take to clear its faults after a reset. No motor is driven meanwhile.
inline constexpr double kBoardReset_s = 0.1;

/// Limits of voltage, current and force reduce e_W: when lowered or raised they change at the rate
/// of the device's limit per this time, so that there is no force step.
inline constexpr double kLimitGlide_s = 1.0;

/// State of the connection: how a measurement arrived, and the board's own status.
struct Link {
    device::DeviceHealth health = device::DeviceHealth::ok;
    device::Arrival arrival = device::Arrival::fresh;
    device::BoardFaults faults;
    std::uint32_t missed_in_a_row = 0; ///< deadlines, before this and the preceding late ticks
    std::uint8_t zeroing = 1;          ///< see device::Measurement
};

/// The monitor's inputs of one tick.
struct Observation {
    Link link;
    control::Configuration now;
    Vector3 tip_force_N{Vector3::Zero()}; ///< rendered force, J⁻ᵀ k_T i
    Vector3 current_A{Vector3::Zero()};
    bool touching = false;
    Vector3 spring_force_N{Vector3::Zero()};   ///< requested static force (19) of the coupling
    Vector3 spring_stretch_m{Vector3::Zero()}; ///< from the tip to the proxy, when touching
    /// The same with the tuning of the previous tick; differs only while a tuning changes.
    Vector3 spring_force_before_N{Vector3::Zero()};
    control::ObservedMotors motors;  ///< for which the command was computed
    Vector3 trim_V{Vector3::Zero()}; ///< in it
    /// What was observed of windings as warm as the air; for those that are observed and trusted.
    std::array<control::ResistanceEstimate, 3> unheated{};
    /// What happened to each motor since the last measurement, if that is known.
    std::array<std::optional<control::DrivenInterval>, 3> interval;
    bool has_inductance = true;       ///< currents are those of windings with the file's L
    bool scene_is_new = false;        ///< the spring is not that of the previous tick
    bool all_finite = true;           ///< of everything else on the signal path
    std::uint32_t missed_periods = 0; ///< since the last new measurement
};

/// Requests from the window to the monitor.
struct SafetyOrders {
    SafetyLimits limits = unlowered(); ///< lower the device's limits
    std::uint32_t requested_stop = 0;  ///< see ServoInputs
    std::uint32_t released_stop = 0;   ///< the same
    std::uint32_t heartbeat = 0;
    bool release = false; ///< ramp down and release the device
};

class SafetyMonitor {
public:
    SafetyMonitor(device::DeviceDescription device, double period_s);

    /// Sets T from the next tick on; keeps the state. RT-safe.
    void set_period(double period_s) noexcept;

    /// The command that may go to the device. RT-safe.
    device::DeviceCommand pass(const device::DeviceCommand &requested, const Observation &seen,
                               const SafetyOrders &orders) noexcept;

    /// The same for a tick without a new measurement: the active command is held until the limit
    /// for stale measurements is reached. RT-safe.
    device::DeviceCommand hold(const device::DeviceCommand &active, const Link &link,
                               const SafetyOrders &orders) noexcept;

    /// For a time that is not known, nobody watched the windings, see WindingGuard::resume.
    /// RT-safe.
    void resume_watch(const std::array<device::MotorTemperature, 3> &hottest) noexcept;

    /// Clears a trip and starts again; if the cause persists, the next `pass` trips again. Faults
    /// of the device's board get kBoardReset_s, in which the board is told to clear them until a
    /// report is missing: what nobody saw is not cleared. A trip by a failed assertion stays,
    /// because the servo's state cannot be trusted, and so does one with a held stop beyond
    /// `released_stop`. Returns whether it was cleared. RT-safe.
    bool reset(std::uint32_t released_stop = 0) noexcept;

    /// Trips in any state; returns the safe state. RT-safe.
    [[nodiscard]] device::DeviceCommand fail(const AssertionFailure &failure) noexcept;

    /// Whether the requested command reaches the motors, at least in part.
    [[nodiscard]] bool lets_pass() const { return servo::lets_pass(status_.state); }

    [[nodiscard]] const SafetyStatus &status() const { return status_; }
    [[nodiscard]] const SafetyLimits &limits() const { return limits_; }
    [[nodiscard]] const ActiveLimits &active_limits() const { return active_limits_; }
    [[nodiscard]] const std::array<WindingStatus, 3> &windings() const { return winding_; }
    [[nodiscard]] double generated_energy_J() const { return energy_.generated_J(); }

private:
    void approach_limits(const SafetyLimits &requested) noexcept;
    void watch_windings(const Observation &seen) noexcept;
    void watch_balances(const Observation &seen) noexcept;
    void watch_window(const SafetyOrders &orders, double elapsed_s) noexcept;
    void watch_link(const Link &link, double elapsed_s) noexcept;
    void watch_stops(const Link &link, const SafetyOrders &orders) noexcept;
    void watch_energy(const Observation &seen) noexcept;
    void trip(TripCause cause, double measured = 0.0, double limit = 0.0) noexcept;
    void trip_above(TripCause cause, double measured, double limit) noexcept;
    void trip_counts_above(TripCause cause, double measured, double limit) noexcept;
    void check_link(const Link &link) noexcept;
    void check_clocks(const Link &link) noexcept;
    [[nodiscard]] bool is_resetting_board() const noexcept { return board_reset_left_s_ > 0.0; }
    void check(const device::DeviceCommand &requested, const Observation &seen,
               const SafetyOrders &orders) noexcept;
    [[nodiscard]] device::DeviceCommand safe_state() const noexcept;
    void check_motion(const Observation &seen, bool is_released) noexcept;
    void check_consistency(const Observation &seen) noexcept;
    void check_windings(const Vector3 &current_A) noexcept;
    void check_voltage(const LimitedCommand &passed) noexcept;
    [[nodiscard]] LimitedCommand apply_limits(const device::DeviceCommand &requested,
                                              const Observation &seen) noexcept;
    void proceed(bool release) noexcept;

    device::DeviceDescription device_;
    double period_s_;
    SafetyLimits device_limits_;
    SafetyLimits limits_; ///< active
    double max_R_hat_rate_Ohm_per_s_;
    std::array<device::WindingGuard, 3> guard_;
    std::array<device::WindingBalance, 3> balance_;
    Vector3 passed_e_W_V_{Vector3::Zero()}; ///< of the previous tick's command
    std::array<MotorConsistency, 3> consistency_;
    std::array<WindingStatus, 3> winding_{};
    EnergyObserver energy_;
    RestDetector rest_;
    bool has_tip_ = false;
    Vector3 tip_m_{Vector3::Zero()}; ///< of the previous tick
    double cut_off_s_ = 0.0;         ///< how long e_W has been clamped at the supply
    std::uint32_t heartbeat_ = 0;
    double window_silent_s_ = 0.0;
    double stale_s_ = 0.0;               ///< since the last fresh measurement
    std::uint32_t held_ticks_ = 0;       ///< since the last new measurement
    bool amplifier_is_at_fault_ = false; ///< as last reported by the board
    bool board_has_faults_ = false;      ///< the same
    std::uint8_t zeroing_ = 1;           ///< of the counts, see device::Measurement
    bool voids_zero_ = false;            ///< this tick contradicts it
    double board_reset_left_s_ = 0.0;    ///< of kBoardReset_s
    bool clears_board_ = false;          ///< in it, until a report is missing
    bool switch_is_on_ = false;          ///< stop switch or enable line, as the board latched it
    bool switch_is_pressed_ = false;     ///< the same, at present
    std::uint32_t last_stop_ = 0;        ///< number of the last requested stop
    ActiveLimits active_limits_;
    double force_share_ = 1.0; ///< passed on by the limiter in the previous tick
    SafetyStatus status_;
};

} // namespace springdrive::servo
