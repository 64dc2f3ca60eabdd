// What the safety monitor says of itself: its state, why it tripped, and what it held back.
#pragma once

#include "base/assertions.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace springdrive::servo {

enum class SafetyState : std::uint8_t {
    waiting,  ///< braking, until the tip has been at rest in free space
    starting, ///< gains rise from nothing
    running,
    tripped,   ///< braking, until a deliberate reset
    releasing, ///< gains fall to nothing, since the device is to be let go of
};

/// Whether what is wanted reaches the motors, at least in part.
[[nodiscard]] constexpr bool lets_pass(SafetyState state) {
    return state == SafetyState::starting || state == SafetyState::running ||
           state == SafetyState::releasing;
}

/// In the order in which they are looked for: a fault of the measurement comes before what it makes
/// of speed, force and energy. The last is not looked for, it happens; and no reset leaves it.
enum class TripCause : std::uint8_t {
    none,
    emergency_stop,
    device_lost,
    board_fault,
    stale_measurement,
    not_finite,
    torn_inputs, ///< of old records: a hand-over that cannot tear is not looked at any more
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
    assertion, ///< one failed on the servo's thread
};

/// Their names in records, by their number.
inline constexpr std::array<std::string_view, 18> kTripCauseNames{
    "none",       "emergency_stop", "device_lost",      "board_fault",         "stale_measurement",
    "not_finite", "torn_inputs",    "missed_deadlines", "window_silent",       "encoder_jump",
    "current",    "tip_force",      "tip_speed",        "winding_temperature", "beyond_stops",
    "energy",     "voltage",        "assertion"};

/// Whether only a new start of the program leaves it.
[[nodiscard]] constexpr bool is_final(TripCause cause) { return cause == TripCause::assertion; }

struct SafetyStatus {
    SafetyState state = SafetyState::waiting;
    TripCause cause = TripCause::none;
    /// What crossed the limit, in the limit's SI unit, or the bits of a board's faults; 0 where
    /// nothing did.
    double measured = 0.0;
    double limit = 0.0;
    double ramp = 0.0;          ///< 0 to 1, share of the command that passes
    AssertionFailure failure{}; ///< of TripCause::assertion; not in records, but as a note
};

/// What was made less of in a tick, so that nothing passed its limit.
struct ActiveLimits {
    bool force = false;   ///< e_W, for the tip force or a winding's current that it would settle at
    bool voltage = false; ///< e_W, for the supply
    bool at_edge = false; ///< e_W, by the soft wall at the edge of the workspace
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

} // namespace springdrive::servo
