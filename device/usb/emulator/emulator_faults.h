// Faults that an emulated board can show on demand, and their text form on a command line.
//
//   NAME[:ARGUMENT...][@BEGIN[-END]]     drop:in:0.01   stuck-encoder:2@1.5-2   unplug@3.5
//
// BEGIN and END are times since the emulator's start, by the board's clock [s]; without them a
// fault acts always. Channels are numbered from 1 in texts, and from 0 in `Fault`.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

namespace springdrive::emulator {

enum class FaultKind : std::uint8_t {
    // Of packets, in one direction:
    drop,
    delay,
    reorder, ///< swapped with the next packet
    corrupt, ///< one to three bits are flipped
    repeat,
    truncate,
    stall, ///< nothing passes; see EmulatedBoard::is_stalled
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
    brown_out, ///< below kLeastLogicSupply_V the board is off, and restarts afterwards
    // Of the whole board:
    stop,         ///< the stop switch is pressed
    disable,      ///< the enable line is open
    restart,      ///< at once, without leaving the bus
    unplug,       ///< by whoever holds the device: EmulatedBoard::unplug_wanted
    failed_store, ///< of calibrations
};
inline constexpr std::size_t kFaultKinds = 25;

[[nodiscard]] constexpr bool is_of_packets(FaultKind kind) { return kind <= FaultKind::stall; }

/// Of a USB transfer, as seen by the host.
enum class Direction : std::uint8_t { in, out };

struct Fault {
    FaultKind kind = FaultKind::drop;
    double begin_s = 0.0;
    double end_s = std::numeric_limits<double>::infinity();
    Direction direction = Direction::out;
    double share = 1.0;       ///< of the packets, at random; of the counts, evenly
    std::uint64_t packet = 0; ///< only this one of its direction, from 1; 0: by `share`
    double periods = 1.0;     ///< of reports: duration of a delay
    std::size_t channel = 0;
    std::size_t other_channel = 1;
    double gain = 1.0; ///< of a current sensor
    double supply_V = 0.0;
    double temperature_C = 0.0;
};

/// What follows a fault's name.
enum class FaultForm : std::uint8_t {
    nothing,
    packets,     ///< DIRECTION[:SHARE or :#NUMBER]
    delay,       ///< the same, and [:PERIODS]
    endpoint,    ///< DIRECTION
    channel,     ///< CHANNEL
    two,         ///< CHANNEL:CHANNEL
    counts,      ///< CHANNEL:SHARE
    gain,        ///< CHANNEL:GAIN
    supply,      ///< VOLTS
    temperature, ///< CELSIUS
};

struct FaultName {
    std::string_view name;
    FaultKind kind = FaultKind::drop;
    FaultForm form = FaultForm::nothing;
};

/// All faults, in the order of FaultKind.
inline constexpr std::array<FaultName, kFaultKinds> kFaultNames{{
    {"drop", FaultKind::drop, FaultForm::packets},
    {"delay", FaultKind::delay, FaultForm::delay},
    {"reorder", FaultKind::reorder, FaultForm::packets},
    {"corrupt", FaultKind::corrupt, FaultForm::packets},
    {"repeat", FaultKind::repeat, FaultForm::packets},
    {"truncate", FaultKind::truncate, FaultForm::packets},
    {"stall", FaultKind::stall, FaultForm::endpoint},
    {"stuck-encoder", FaultKind::stuck_encoder, FaultForm::channel},
    {"reversed-encoder", FaultKind::reversed_encoder, FaultForm::channel},
    {"crossed-encoders", FaultKind::crossed_encoders, FaultForm::two},
    {"lost-counts", FaultKind::lost_counts, FaultForm::counts},
    {"failed-sensor", FaultKind::failed_sensor, FaultForm::channel},
    {"reversed-sensor", FaultKind::reversed_sensor, FaultForm::channel},
    {"crossed-sensors", FaultKind::crossed_sensors, FaultForm::two},
    {"sensor-gain", FaultKind::sensor_gain, FaultForm::gain},
    {"open-winding", FaultKind::open_winding, FaultForm::channel},
    {"crossed-motors", FaultKind::crossed_motors, FaultForm::two},
    {"failed-stage", FaultKind::failed_stage, FaultForm::nothing},
    {"hot-stage", FaultKind::hot_stage, FaultForm::temperature},
    {"brown-out", FaultKind::brown_out, FaultForm::supply},
    {"stop", FaultKind::stop, FaultForm::nothing},
    {"disable", FaultKind::disable, FaultForm::nothing},
    {"restart", FaultKind::restart, FaultForm::nothing},
    {"unplug", FaultKind::unplug, FaultForm::nothing},
    {"failed-store", FaultKind::failed_store, FaultForm::nothing},
}};

[[nodiscard]] constexpr std::string_view name_of(FaultKind kind) {
    return kFaultNames[static_cast<std::size_t>(kind)].name;
}

/// How to write what follows a name.
[[nodiscard]] constexpr std::string_view usage_of(FaultForm form) {
    switch (form) {
    case FaultForm::nothing:
        return "";
    case FaultForm::packets:
        return ":in|out[:SHARE|:#NUMBER]";
    case FaultForm::delay:
        return ":in|out[:SHARE|:#NUMBER[:PERIODS]]";
    case FaultForm::endpoint:
        return ":in|out";
    case FaultForm::channel:
        return ":1|2|3";
    case FaultForm::two:
        return ":1|2|3:1|2|3";
    case FaultForm::counts:
        return ":1|2|3:SHARE";
    case FaultForm::gain:
        return ":1|2|3:GAIN";
    case FaultForm::supply:
        return ":VOLTS";
    case FaultForm::temperature:
        return ":CELSIUS";
    }
    return "";
}

/// @throw InputError naming the text, what is wrong with it, and how such a fault is written
[[nodiscard]] Fault parse_fault(std::string_view text);

/// One line for each fault, for a command's help.
[[nodiscard]] std::string fault_usage();

} // namespace springdrive::emulator
