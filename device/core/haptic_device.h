// The one interface to a haptic device, simulated or real. Nothing above it knows which it has.
//
//   read() ──► Measurement ──► one servo tick ──► DeviceCommand ──► write()
//
// Two calls, so that an answer leaves as soon as it is known, not a period later. What passes
// between the moment of a measurement and the moment at which the windings get its answer is d.
#pragma once

#include "base/vector.h"
#include "device/core/device_file.h"

#include <array>
#include <cstdint>
#include <limits>
#include <string>

namespace springdrive::device {

/// What the three amplifiers are to do.
enum class CommandMode : std::uint8_t {
    brake, ///< the safe state: e_W = 0 and R̂ = 0, each winding shorted through its own resistance,
           ///< so that the device resists like the damper B_R of (5)
    drive, ///< (6) with e_W and R̂
    open,  ///< windings open: only where an amplifier itself is at fault
};

/// What the amplifiers are asked to do until the next command. Without voltages, braking.
struct DeviceCommand {
    Vector3 e_W_V{Vector3::Zero()};                    ///< e_W of (6), per motor
    Vector3 cancelled_resistance_Ohm{Vector3::Zero()}; ///< R̂ of (6), per motor
    CommandMode mode = CommandMode::drive;
    std::uint64_t number = 0; ///< of the measurement that it answers

    [[nodiscard]] static DeviceCommand braking() {
        DeviceCommand command;
        command.mode = CommandMode::brake;
        return command;
    }

    [[nodiscard]] bool is_finite() const {
        return e_W_V.allFinite() && cancelled_resistance_Ohm.allFinite();
    }
};

enum class DeviceHealth : std::uint8_t {
    ok,
    lost, ///< the device is gone; counts and currents are the last known
};

/// How a measurement came.
enum class Arrival : std::uint8_t {
    fresh,    ///< measured for this tick
    late,     ///< new, but measured for a tick before
    repeated, ///< the last one once more
    corrupt,  ///< what came cannot be trusted; counts and currents are the last good ones
    absent,   ///< nothing came in time; counts and currents are the last good ones
};

/// Whether it tells anything that was not known before.
[[nodiscard]] constexpr bool has_news(Arrival arrival) {
    return arrival == Arrival::fresh || arrival == Arrival::late;
}

/// What a board says is wrong with it, one bit each.
struct BoardFaults {
    static constexpr std::uint16_t kAmplifier = 1U << 0U;   ///< a power stage: opens the windings
    static constexpr std::uint16_t kOverCurrent = 1U << 1U; ///< the board's own limit was met
    static constexpr std::uint16_t kTemperature = 1U << 2U; ///< of its power stages
    static constexpr std::uint16_t kSupply = 1U << 3U;      ///< too high or too low
    static constexpr std::uint16_t kEncoder = 1U << 4U;     ///< its signals make no sense
    static constexpr std::uint16_t kNoCommand = 1U << 5U;   ///< none came in time: it brakes

    std::uint16_t bits = 0;

    [[nodiscard]] constexpr bool any() const { return bits != 0; }
    [[nodiscard]] constexpr bool has(std::uint16_t fault) const { return (bits & fault) != 0; }
};

/// What the device measured, and what it says of itself.
struct Measurement {
    std::array<std::int32_t, 3> counts{}; ///< encoders, zero at θ = 0
    Vector3 current_A{Vector3::Zero()};   ///< winding currents i; τ = k_T i (3)
    std::uint64_t number = 0;             ///< of the servo period that it was measured in
    double time_s = 0.0;                  ///< when it was measured, by the device's clock
    Arrival arrival = Arrival::fresh;
    DeviceHealth health = DeviceHealth::ok;
    BoardFaults faults;
    double supply_V = std::numeric_limits<double>::quiet_NaN(); ///< where the board measures it
};

/// Whose time a device's measurements go by.
enum class DeviceClock : std::uint8_t {
    servo, ///< the servo's: from number to number a period passes, and time waits for the servo
    own,   ///< its own, which does not wait: `Measurement::time_s` tells
};

/// Which of all devices it is.
struct DeviceIdentity {
    std::string kind;     ///< "simulated", "USB"
    std::string serial;   ///< tells two of a kind apart
    std::string firmware; ///< what runs on its board
};

class HapticDevice {
public:
    HapticDevice() = default;
    HapticDevice(const HapticDevice &) = delete;
    HapticDevice &operator=(const HapticDevice &) = delete;
    virtual ~HapticDevice() = default;

    [[nodiscard]] virtual const DeviceDescription &description() const = 0;
    [[nodiscard]] virtual DeviceClock clock() const = 0;

    /// d: servo periods, whole or not, from a measurement until the answer to it reaches the
    /// windings.
    [[nodiscard]] virtual double delay_periods() const = 0;

    /// Once at the start of a servo tick: the newest measurement. RT-safe.
    [[nodiscard]] virtual Measurement read() noexcept = 0;

    /// Once at its end; holds until the next. RT-safe.
    virtual void write(const DeviceCommand &command) noexcept = 0;

    // The rest is not for the servo's thread: nobody may be within `read` or `write` meanwhile.

    [[nodiscard]] virtual DeviceIdentity identity() const = 0;

    /// The servo's period T from the next `read` on [s].
    /// @throw InputError for one that the device cannot keep
    virtual void set_period(double period_s) = 0;

    /// Its rotors stand at these angles now; counts say so from the next `read` on.
    virtual void zero(const Vector3 &theta_rad) = 0;

    /// Brakes, and lets go of the device: it is lost from then on.
    virtual void close() noexcept = 0;

    /// Takes hold of it again after it was lost or closed. It brakes, and has to be zeroed.
    /// @throw InputError where it cannot be found
    virtual void reconnect() = 0;
};

} // namespace springdrive::device
