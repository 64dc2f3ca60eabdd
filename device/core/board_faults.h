// Faults that a device's board reports.
#pragma once

#include <cstdint>
#include <string>

namespace springdrive::device {

/// Faults reported by the device's board, one bit each.
struct BoardFaults {
    static constexpr std::uint16_t kAmplifier = 1U << 0U;   ///< a power stage: opens the windings
    static constexpr std::uint16_t kOverCurrent = 1U << 1U; ///< the board's own limit was reached
    static constexpr std::uint16_t kTemperature = 1U << 2U; ///< of its power stages or motors
    static constexpr std::uint16_t kSupply = 1U << 3U;      ///< too high or too low
    static constexpr std::uint16_t kEncoder = 1U << 4U;     ///< implausible encoder signals
    static constexpr std::uint16_t kNoCommand = 1U << 5U;   ///< none came in time: the board brakes
    static constexpr std::uint16_t kStop = 1U << 6U;        ///< stop switch or enable line
    static constexpr std::uint16_t kHeat = 1U << 7U;        ///< of a winding, by its currents
    static constexpr std::uint16_t kSensor = 1U << 8U;      ///< a current sensor: opens
    static constexpr std::uint16_t kOverrun = 1U << 9U;     ///< its amplifiers' loop was late
    /// No fault, and not latched: the stop switch is pressed, or the enable line open.
    static constexpr std::uint16_t kPressed = 1U << 15U;

    std::uint16_t bits = 0;

    [[nodiscard]] constexpr bool any() const { return (bits & ~kPressed) != 0; }
    [[nodiscard]] constexpr bool has(std::uint16_t fault) const { return (bits & fault) != 0; }
};

/// "overcurrent, a command timeout"; "an unknown fault" for bits without a name, "none" without
/// bits.
[[nodiscard]] std::string names_of(BoardFaults faults);

} // namespace springdrive::device
