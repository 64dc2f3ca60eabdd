// Status of the safety monitor: its state, why it tripped, and what it limited.
#pragma once

#include "base/assertions.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace springdrive::servo {

enum class SafetyState : std::uint8_t {
    waiting,  ///< braking, until the tip has been at rest in free space
    starting, ///< gains ramp up from zero
    running,
    tripped,   ///< braking, until a deliberate reset
    releasing, ///< gains ramp down to zero to release the device
};

/// Whether the requested command reaches the motors, at least in part.
[[nodiscard]] constexpr bool lets_pass(SafetyState state) {
    return state == SafetyState::starting || state == SafetyState::running ||
           state == SafetyState::releasing;
}

/// Up to `assertion`, which is not the result of a check, in the order of the checks: a faulty
/// measurement comes before its consequences for speed, force and energy.
enum class TripCause : std::uint8_t {
    none,
    emergency_stop,
    device_lost,
    board_fault,
    stale_measurement,
    not_finite,
    torn_inputs, ///< in old records only: today's mailbox cannot tear
    missed_deadlines,
    window_silent,
    encoder_jump,
    current,
    tip_force,
    tip_speed,
    winding_temperature,
    beyond_stops,
    energy,
    voltage,
    assertion,          ///< failed on the servo's thread
    motor_contradicted, ///< checked after encoder_jump; last, as records index these
};

/// Names in records, indexed by TripCause.
inline constexpr std::array<std::string_view, 19> kTripCauseNames{
    "none",       "emergency_stop", "device_lost",      "board_fault",         "stale_measurement",
    "not_finite", "torn_inputs",    "missed_deadlines", "window_silent",       "encoder_jump",
    "current",    "tip_force",      "tip_speed",        "winding_temperature", "beyond_stops",
    "energy",     "voltage",        "assertion",        "motor_contradicted"};

/// Whether only a restart of the program clears it.
[[nodiscard]] constexpr bool is_final(TripCause cause) { return cause == TripCause::assertion; }

struct SafetyStatus {
    SafetyState state = SafetyState::waiting;
    TripCause cause = TripCause::none;
    /// The value that exceeded the limit, in the limit's SI unit, or the bits of a board's faults;
    /// else 0.
    double measured = 0.0;
    double limit = 0.0;
    double ramp = 0.0;          ///< 0 to 1, share of the command that is passed on
    AssertionFailure failure{}; ///< for TripCause::assertion; in records only as a note
    /// Number of the last requested stop, by window or switch, that no person has released;
    /// 0: none. It keeps the motors off, whatever tripped first.
    std::uint32_t held_stop = 0;
};

/// The limit within which the steady force and currents of a command are kept.
enum class ForceLimit : std::uint8_t { none, tip_force, current1, current2, current3, singular };

/// Indexed by ForceLimit.
inline constexpr std::array<std::string_view, 6> kForceLimitNames{
    "none", "tip_force", "current1", "current2", "current3", "singular"};

/// What was reduced in a tick to keep within the limits.
struct ActiveLimits {
    ForceLimit force = ForceLimit::none; ///< e_W, because of this limit
    bool voltage = false;                ///< e_W, because of the supply
    bool at_edge = false;                ///< the soft wall at the edge of the workspace acts on e_W

    [[nodiscard]] bool holds_force() const { return force != ForceLimit::none; }
};

/// The monitor's estimates for one winding, and their effect in the last tick.
struct WindingStatus {
    double min_C = 0.0;           ///< lower bound of its temperature
    double max_C = 0.0;           ///< upper bound of its temperature
    double R_hat_limit_Ohm = 0.0; ///< the largest safe R̂
    bool is_limited = false;      ///< whether more than that was requested
    bool is_contradicted = false; ///< observations of its R excluded each other, or it generates
    bool generates = false;       ///< R̂ was above R since the last reset, see WindingBalance
    double max_housing_C = 0.0;   ///< upper bound of its housing's temperature
};

/// Why it tripped, with the numbers: "winding current 5.57 A, limit 5.50 A". Allocates.
[[nodiscard]] std::string description(const SafetyStatus &status);

} // namespace springdrive::servo
