// Faults that a device can show on demand, and which of them act now. What they do is done where
// the data are: to packets (usb/emulator/emulated_board.h), to a board's pins
// (usb/emulator/emulated_plant.h), or to what a driver shows (engine/lab/rig/servo_rig.h).
//
//   NAME[:ARGUMENT...][@BEGIN[-END]]     drop:in:0.01   stuck-encoder:2@1.5-2   unplug@3.5
//
// BEGIN and END are times by the device's clock [s], an emulated board's since its start; without
// them a fault acts always. Channels are numbered from 1 in texts, and from 0 in `Fault`.
#pragma once

#include "base/vector.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::device {

enum class FaultKind : std::uint8_t {
    // Of packets, in one direction; of a driver, of its measurements:
    drop,
    delay,
    reorder, ///< swapped with the next packet
    corrupt, ///< one to three bits are flipped
    repeat,
    truncate,
    stall, ///< nothing passes
    // Of encoders:
    stuck_encoder,
    reversed_encoder,
    crossed_encoders,
    lost_counts,
    // Of current sensors:
    failed_sensor, ///< no conversion: NaN
    reversed_sensor,
    crossed_sensors,
    sensor_gain,
    // Of motors:
    open_winding,
    crossed_motors, ///< two motors at each other's bridges; encoders are not crossed
    // Of power:
    failed_stage,
    hot_stage,
    brown_out, ///< below kMinLogicSupply_V the board is off, and restarts afterwards
    // Of the whole board:
    stop,         ///< the stop switch is pressed
    disable,      ///< the enable line is open
    restart,      ///< at once, without leaving the bus
    unplug,       ///< by whoever holds the device: EmulatedBoard::unplug_requested
    failed_store, ///< of calibrations
    // Without a text: of what a driver shows, for each motor by `size`:
    board,           ///< its board reports the faults of size[0], as bits
    count_step,      ///< counts off by the size [counts]
    count_flicker,   ///< the same, in every other period
    count_drift,     ///< counts that run away by the size in each period [counts]
    late_counts,     ///< counts of size[0] periods ago
    count_scale,     ///< counts from where they were, times the size: 0 is frozen, −1 reversed
    count_stuck_bit, ///< this bit of them, where it is not zero, is 0
    current_reading, ///< currents read as the size where it is not zero [A]
    current_offset,  ///< currents read too high by the size [A]
    current_drift,   ///< the same, more in each period [A]
    current_gain,    ///< currents read as 1 + the size times themselves
    sagging_winding, ///< R less by the size [Ω]
    amplifier_gain,  ///< e_W times the size; −1 is a swapped pair of wires
};

[[nodiscard]] constexpr bool is_of_packets(FaultKind kind) { return kind <= FaultKind::stall; }

/// Of a USB transfer, as seen by the host.
enum class Direction : std::uint8_t { in, out };

struct Fault {
    FaultKind kind = FaultKind::drop;
    Vector3 size{Vector3::Zero()}; ///< by `kind`: of each motor, or a gain, a voltage [V], a
                                   ///< temperature [°C]
    double begin_s = 0.0; ///< of the device's clock; of a FaultyDevice, the number of the read
    double end_s = std::numeric_limits<double>::infinity();
    Direction direction = Direction::out;
    double share = 1.0;       ///< of the packets, at random; of the counts, evenly
    std::uint64_t packet = 0; ///< only this one of its direction, from 1; 0: by `share`
    double periods = 1.0;     ///< of reports: duration of a delay
    std::size_t channel = 0;
    std::size_t other_channel = 1;
};

struct FaultName {
    FaultKind kind = FaultKind::drop;
    std::string_view name;
    std::string_view usage; ///< how to write what follows it, for people; the parser goes by it
};

inline constexpr std::size_t kNamedFaults = 25;
/// In the order of FaultKind.
inline constexpr std::array<FaultName, kNamedFaults> kFaultNames{{
    {FaultKind::drop, "drop", ":in|out[:SHARE|:#NUMBER]"},
    {FaultKind::delay, "delay", ":in|out[:SHARE|:#NUMBER[:PERIODS]]"},
    {FaultKind::reorder, "reorder", ":in|out[:SHARE|:#NUMBER]"},
    {FaultKind::corrupt, "corrupt", ":in|out[:SHARE|:#NUMBER]"},
    {FaultKind::repeat, "repeat", ":in|out[:SHARE|:#NUMBER]"},
    {FaultKind::truncate, "truncate", ":in|out[:SHARE|:#NUMBER]"},
    {FaultKind::stall, "stall", ":in|out"},
    {FaultKind::stuck_encoder, "stuck-encoder", ":1|2|3"},
    {FaultKind::reversed_encoder, "reversed-encoder", ":1|2|3"},
    {FaultKind::crossed_encoders, "crossed-encoders", ":1|2|3:1|2|3"},
    {FaultKind::lost_counts, "lost-counts", ":1|2|3:SHARE"},
    {FaultKind::failed_sensor, "failed-sensor", ":1|2|3"},
    {FaultKind::reversed_sensor, "reversed-sensor", ":1|2|3"},
    {FaultKind::crossed_sensors, "crossed-sensors", ":1|2|3:1|2|3"},
    {FaultKind::sensor_gain, "sensor-gain", ":1|2|3:GAIN"},
    {FaultKind::open_winding, "open-winding", ":1|2|3"},
    {FaultKind::crossed_motors, "crossed-motors", ":1|2|3:1|2|3"},
    {FaultKind::failed_stage, "failed-stage", ""},
    {FaultKind::hot_stage, "hot-stage", ":CELSIUS"},
    {FaultKind::brown_out, "brown-out", ":VOLTS"},
    {FaultKind::stop, "stop", ""},
    {FaultKind::disable, "disable", ""},
    {FaultKind::restart, "restart", ""},
    {FaultKind::unplug, "unplug", ""},
    {FaultKind::failed_store, "failed-store", ""},
}};
static_assert([] {
    for (std::size_t i = 0; i < kNamedFaults; ++i) {
        if (kFaultNames[i].kind != static_cast<FaultKind>(i)) {
            return false;
        }
    }
    return true;
}());

/// @pre it has a text
[[nodiscard]] constexpr std::string_view name_of(FaultKind kind) {
    return kFaultNames[static_cast<std::size_t>(kind)].name;
}

/// @throw InputError naming the text, what is wrong with it, and how such a fault is written
[[nodiscard]] Fault parse_fault(std::string_view text);

/// One line for each fault with a text, for a command's help.
[[nodiscard]] std::string fault_usage();

/// The faults of one device.
class FaultInjector {
public:
    explicit FaultInjector(double ticks_per_s) : ticks_per_s_(ticks_per_s) {}

    /// The first tick at or after that time.
    [[nodiscard]] std::uint64_t tick_at(double time_s) const;

    void add(const Fault &fault);
    void clear();

    /// Advances to a tick. @return whether faults began, ended, or were added or removed. RT-safe.
    bool update(std::uint64_t tick) noexcept;

    /// Those that act now.
    [[nodiscard]] std::span<const Fault> active() const { return active_; }
    /// The last of a kind that acts now, of any or one channel; null if there is none.
    [[nodiscard]] const Fault *find(FaultKind kind,
                                    std::optional<std::size_t> channel = {}) const noexcept;
    /// Whether one began in the last update with a change.
    [[nodiscard]] bool has_begun(FaultKind kind) const noexcept;
    /// Which channel is at the place of each one.
    [[nodiscard]] std::array<std::size_t, 3> crossed(FaultKind kind) const noexcept;

private:
    struct Scheduled {
        Fault fault;
        std::uint64_t begin = 0;
        std::uint64_t end = 0;
        bool acts = false;
        bool begins = false;
    };
    double ticks_per_s_;
    std::vector<Scheduled> faults_;
    std::vector<Fault> active_;
    std::uint64_t next_change_ = 0;
};

} // namespace springdrive::device
