// The interface to a haptic device, simulated or real. Code above it does not know which it is.
//
//   read() ──► Measurement ──► one servo tick ──► DeviceCommand ──► write()
//
// Two calls, so that a command leaves as soon as it is computed, not a period later. The time from
// a measurement until the command computed from it reaches the windings is d.
#pragma once

#include "base/vector.h"
#include "device/core/bench.h"
#include "device/core/board_faults.h"
#include "device/core/device_description.h"

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

namespace springdrive::device {

/// Operating mode of the three amplifiers.
enum class CommandMode : std::uint8_t {
    brake, ///< the safe state: e_W = 0 and R̂ = 0, each winding shorted through its own resistance,
           ///< so that the device resists like the damper B_R of (5)
    drive, ///< (6) with e_W and R̂
    open,  ///< windings open: only for a fault of an amplifier itself
};

/// The command to the amplifiers until the next one. Without voltages it brakes.
struct DeviceCommand {
    Vector3 e_W_V{Vector3::Zero()};                    ///< e_W of (6), per motor
    Vector3 cancelled_resistance_Ohm{Vector3::Zero()}; ///< R̂ of (6), per motor
    CommandMode mode = CommandMode::drive;
    std::uint64_t number = 0;   ///< of the measurement from which it was computed
    bool resets_faults = false; ///< the board shall clear faults whose causes have gone; brakes
    bool voids_zero = false;    ///< the last measurement contradicts the zero of the counts

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
    lost, ///< no connection; counts and currents are the last known
};

/// The connection to a device, for display.
struct LinkStatus {
    std::string speed;         ///< "high speed (480 Mbit/s)"
    std::string board_state;   ///< "driving"
    std::string warning;       ///< what the system refused to the link; empty if nothing
    std::string last_problem;  ///< of a packet, in words; empty if there was none
    double report_rate_hz = 0; ///< requested

    // Of the latest ones; 0 until they are known.
    double delay_s = 0.0;              ///< d T, mean
    double longest_delay_s = 0.0;      ///< d T
    double round_trip_s = 0.0;         ///< of packets alone, mean
    double longest_round_trip_s = 0.0; ///< the same

    // Since the connection.
    std::uint64_t reports = 0;  ///< valid and new
    std::uint64_t lost = 0;     ///< reports whose numbers are missing
    std::uint64_t late = 0;     ///< ticks whose newest report was measured for an earlier one
    std::uint64_t absent = 0;   ///< ticks without a new report
    std::uint64_t repeated = 0; ///< reports that came twice
    std::uint64_t stale = 0;    ///< reports that came after newer ones
    std::uint64_t corrupt = 0;  ///< packets that are no valid report
    std::uint64_t unsent = 0;   ///< commands that could not be sent
    std::uint64_t rejected = 0; ///< packets that the board rejected
};

/// How a measurement arrived.
enum class Arrival : std::uint8_t {
    fresh,    ///< measured for this tick
    late,     ///< new, but measured for an earlier tick
    repeated, ///< the last one again
    corrupt,  ///< invalid data; counts and currents are the last good ones
    absent,   ///< nothing arrived in time; counts and currents are the last good ones
};

/// Whether the measurement is new.
[[nodiscard]] constexpr bool is_new(Arrival arrival) {
    return arrival == Arrival::fresh || arrival == Arrival::late;
}

/// What the device measured, and its status.
struct Measurement {
    std::array<std::int32_t, 3> counts{}; ///< encoders, zero at θ = 0
    Vector3 current_A{Vector3::Zero()};   ///< winding currents i; τ = k_T i (3)
    std::uint64_t number = 0;             ///< of the servo period in which it was measured
    double time_s = 0.0;                  ///< when it was measured, by the device's clock
    Arrival arrival = Arrival::fresh;
    DeviceHealth health = DeviceHealth::ok;
    BoardFaults faults;
    double supply_V = std::numeric_limits<double>::quiet_NaN(); ///< if the board measures it
    /// 0 while counts do not give the rotors' angles; another number after each zeroing.
    std::uint8_t zeroing = 1;
};

/// The clock that times a device's measurements.
enum class DeviceClock : std::uint8_t {
    servo, ///< the servo's: each number is one period, and device time waits for the servo
    own,   ///< its own, which does not wait: read `Measurement::time_s`
};

/// Identifies a device.
struct DeviceIdentity {
    std::string kind;     ///< "simulated", "USB"
    std::string serial;   ///< distinguishes devices of one kind
    std::string firmware; ///< version on its board
};

class HapticDevice {
public:
    HapticDevice() = default;
    HapticDevice(const HapticDevice &) = delete;
    HapticDevice &operator=(const HapticDevice &) = delete;
    virtual ~HapticDevice() = default;

    [[nodiscard]] virtual const DeviceDescription &description() const = 0;
    [[nodiscard]] virtual DeviceClock clock() const = 0;

    /// Whether its motors' energy can reach a person's hand, or it stands in for a device whose
    /// can. Nothing but a person then starts it again after a stop of an exhibit.
    [[nodiscard]] virtual bool can_reach_a_hand() const { return true; }

    /// d: servo periods, whole or fractional, from a measurement until the command computed from it
    /// reaches the windings. Measured on a real device, as the mean of the latest ones.
    [[nodiscard]] virtual double delay_periods() const = 0;

    /// Called once at the start of a servo tick: the newest measurement. RT-safe.
    [[nodiscard]] virtual Measurement read() noexcept = 0;

    /// Called once at the end of a tick; the command holds until the next. RT-safe.
    virtual void write(const DeviceCommand &command) noexcept = 0;

    // The rest is not for the servo's thread: no thread may be inside `read` or `write` meanwhile.

    [[nodiscard]] virtual DeviceIdentity identity() const = 0;

    /// The connection, of a device that has one. Not on the servo's thread, but while it runs.
    [[nodiscard]] virtual std::optional<LinkStatus> link() const { return std::nullopt; }

    /// Of a device whose board has one; otherwise null.
    [[nodiscard]] virtual Bench *bench() { return nullptr; }

    /// Whether counts give the rotors' angles; otherwise they must be declared by `zero`. A fault
    /// of an encoder, a restart of its board, or a command that says so voids the zero of a device
    /// that counts; a simulated one knows its angles. Any thread.
    [[nodiscard]] virtual bool is_zeroed() const = 0;

    /// Sets the servo's period T from the next `read` on [s].
    /// @throw InputError for a period that the device does not support
    virtual void set_period(double period_s) = 0;

    /// Declares the rotors' current angles; counts refer to them from the next `read` on.
    virtual void zero(const Vector3 &theta_rad) = 0;

    /// Brakes and releases the device, which reports `lost` from then on.
    virtual void close() noexcept = 0;

    /// Connects again after it was lost or closed. The device brakes. It is still zeroed if it can
    /// tell that it kept its counts.
    /// @throw InputError if it cannot be found
    virtual void reconnect() = 0;
};

} // namespace springdrive::device
