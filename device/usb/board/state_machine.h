// The board's states, as a table.
//
//   starting ──offsets──► braking ◄──────► driving
//      ▲                    │ ▲ ▲             │
//    reset             test │ │ └─ brake ── opened ◄─ open
//      │                    ▼ │
//   fault_open            testing         fault_braking ──reset──► braking
//
// A fault leads to fault_braking; of an amplifier or a sensor, or while the windings are open, to
// fault_open. Silence of the host leads from driving and testing to fault_braking.
#pragma once

#include "device/usb/protocol.h"

namespace springdrive::board {

using State = usb::BoardState;

enum class Event : std::uint8_t {
    offsets_ready,
    command_brake,
    command_drive,
    command_open,
    silence,       ///< no command within the watchdog period
    braking_fault, ///< any other than:
    opening_fault, ///< the bridge or a current sensor cannot be relied on
    reset,         ///< requested, and no cause of a fault persists
    test_started,
    test_ended,
};
inline constexpr std::size_t kEvents = 10;

/// Driving needs a command to drive in `braking`. A host that falls silent in `opened` suspected an
/// amplifier, so it stays open.
[[nodiscard]] constexpr State next_state(State state, Event event) {
    using enum usb::BoardState;
    constexpr std::array<std::array<State, kEvents>, usb::kBoardStates> kNext{{
        // offsets_ready, command_brake, _drive, _open, silence,
        // braking_fault, opening_fault, reset, test_started, test_ended
        {braking, starting, starting, starting, starting, // starting
         fault_open, fault_open, starting, starting, starting},
        {braking, braking, driving, opened, braking, // braking
         fault_braking, fault_open, braking, testing, braking},
        {driving, braking, driving, opened, fault_braking, // driving
         fault_braking, fault_open, braking, driving, driving},
        {opened, braking, opened, opened, opened, // opened
         fault_open, fault_open, opened, opened, opened},
        {testing, testing, braking, opened, fault_braking, // testing
         fault_braking, fault_open, braking, testing, braking},
        {fault_braking, fault_braking, fault_braking, fault_open, fault_braking, // fault_braking
         fault_braking, fault_open, braking, fault_braking, fault_braking},
        {fault_open, fault_open, fault_open, fault_open, fault_open, // fault_open
         fault_open, fault_open, starting, fault_open, fault_open},
    }};
    return kNext[static_cast<std::size_t>(state)][static_cast<std::size_t>(event)];
}

/// Faults that open the windings.
inline constexpr std::uint16_t kOpeningFaults = usb::Faults::kAmplifier | usb::Faults::kSensor;

} // namespace springdrive::board
