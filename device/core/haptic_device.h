// The interface to a haptic device, simulated or real. Code above it does not know which it is.
//
//   read() ──► Measurement ──► one servo tick ──► DeviceCommand ──► write()
//
// Two calls, so that a command leaves as soon as it is computed, not a period later. The time from
// a measurement until the command computed from it reaches the windings is d.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

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

/// A voltage of each sign on each winding, the others open.
struct PulseOrder {
    double voltage_V = 0.5;
    double duration_s = 8e-3; ///< of each sign
};

/// What a board measured and found on one channel.
struct ChannelPulse {
    double resistance_Ohm = std::numeric_limits<double>::quiet_NaN(); ///< as its sensor sees it
    double inductance_H = std::numeric_limits<double>::quiet_NaN();   ///< the same
    std::array<int, 3> moved_counts{}; ///< of each encoder, by a positive voltage
    bool is_open = false;              ///< hardly any current
    bool has_reversed_sensor = false;  ///< current against the voltage
    bool has_crossed_sensor = false;   ///< current in another channel
    bool has_no_motion = false;        ///< held, or no encoder
    bool has_reversed_encoder = false; ///< counts against the voltage
    bool has_crossed_encoder = false;  ///< another counts more
    bool is_at_limit = false;          ///< of the test, which ended it
};

enum class PulseState : std::uint8_t { never, running, completed, aborted };

struct PulseResult {
    PulseState state = PulseState::never;
    std::array<ChannelPulse, 3> channel;
};

/// A name and a value with its unit, for people.
struct Fact {
    std::string name;
    std::string value;
};

/// What a device's board does for its commissioning, beside being driven: test pulses on one
/// winding after the other, what it says of itself, and a calibration that it keeps for its host.
///
/// For one thread, while no servo runs. That thread goes on to read measurements and to write
/// braking commands meanwhile, as a board that hears nothing ends its test.
class Bench {
public:
    Bench() = default;
    Bench(const Bench &) = delete;
    Bench &operator=(const Bench &) = delete;
    virtual ~Bench() = default;

    /// The shortest pulse that the board can measure in [s].
    [[nodiscard]] virtual double shortest_pulse_s() const = 0;

    /// @throw InputError if the board refuses, or does not answer
    virtual void start_pulses(const PulseOrder &order) = 0;

    /// Of the pulses that were started last.
    /// @throw InputError if the board does not answer
    [[nodiscard]] virtual PulseResult pulses() = 0;

    /// All that the board says of itself.
    /// @throw InputError if it does not answer
    [[nodiscard]] virtual std::vector<Fact> facts() = 0;

    /// What `store` left there, if anything.
    /// @throw InputError if it does not answer, or if what it has stored is damaged
    [[nodiscard]] virtual std::optional<Calibration> stored_calibration() = 0;

    /// Keeps it without power, too; the numbers as singles.
    /// @throw InputError if the board refuses, as while it drives motors, or does not keep it
    virtual void store(const Calibration &calibration) = 0;
};

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
    /// Whether a command reached the amplifiers since the measurement before.
    bool has_new_command = true;
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

/// Which commands may clear what a board has latched, while a device is tested or zeroed and no
/// servo's safety monitor decides: never a stop that somebody wants, nor what no report showed.
class BoardReset {
public:
    /// @param clears_stop  also one that the first measurement shows, as of whoever begins this
    explicit BoardReset(bool clears_stop) : clears_stop_(clears_stop) {}

    /// To be asked with every measurement. @return whether the answer to it may reset faults
    [[nodiscard]] bool may_follow(const Measurement &measured) noexcept {
        const bool is_first = number_ == 0;
        if (!is_new(measured.arrival)) {
            has_gap_ = has_gap_ || !is_first;
            return false;
        }
        has_gap_ = has_gap_ || (!is_first && measured.number != number_ + 1);
        number_ = measured.number;
        const bool has_stop = measured.faults.has(BoardFaults::kStop);
        const bool is_pressed = measured.faults.has(BoardFaults::kPressed);
        const bool is_pressed_anew = !is_first && is_pressed && !was_pressed_;
        was_pressed_ = is_pressed;
        clears_stop_ = clears_stop_ && has_stop && !is_pressed_anew;
        has_stop_ = has_stop_ || ((has_stop || is_pressed) && !clears_stop_);
        return !has_gap_ && !has_stop_ && measured.faults.any();
    }

    /// Whether a stop was seen that stays.
    [[nodiscard]] bool has_stop() const noexcept { return has_stop_; }

private:
    bool clears_stop_;
    bool has_stop_ = false;
    bool has_gap_ = false;
    bool was_pressed_ = false;
    std::uint64_t number_ = 0; ///< of the last measurement; 0: none
};

/// Decorator that forwards every call to another device; derived classes override what differs.
class ForwardingDevice : public HapticDevice {
public:
    /// @param device  must outlive this one
    explicit ForwardingDevice(HapticDevice &device) : device_(&device) {}
    explicit ForwardingDevice(std::unique_ptr<HapticDevice> device)
        : owned_(std::move(device)), device_(owned_.get()) {}

    [[nodiscard]] const DeviceDescription &description() const override {
        return device_->description();
    }
    [[nodiscard]] DeviceClock clock() const override { return device_->clock(); }
    [[nodiscard]] bool can_reach_a_hand() const override { return device_->can_reach_a_hand(); }
    [[nodiscard]] double delay_periods() const override { return device_->delay_periods(); }
    [[nodiscard]] Measurement read() noexcept override { return device_->read(); }
    void write(const DeviceCommand &command) noexcept override { device_->write(command); }
    [[nodiscard]] DeviceIdentity identity() const override { return device_->identity(); }
    [[nodiscard]] std::optional<LinkStatus> link() const override { return device_->link(); }
    [[nodiscard]] Bench *bench() override { return device_->bench(); }
    [[nodiscard]] bool is_zeroed() const override { return device_->is_zeroed(); }
    void set_period(double period_s) override { device_->set_period(period_s); }
    void zero(const Vector3 &theta_rad) override { device_->zero(theta_rad); }
    void close() noexcept override { device_->close(); }
    void reconnect() override { device_->reconnect(); }

private:
    std::unique_ptr<HapticDevice> owned_;
    HapticDevice *device_;
};

} // namespace springdrive::device
