// What is wrong with a device, as its commissioning found it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace springdrive::commissioning {

enum class Problem : std::uint8_t {
    board_fault,
    wrong_voltage, ///< of all channels
    open_winding,
    reversed_sensor,
    crossed_sensors,
    wrong_sensor_gain,
    wrong_resistance,
    wrong_inductance,
    seized_joint,
    dead_encoder,
    reversed_encoder,
    crossed_encoders,
    wrong_counts, ///< more or fewer than the rotor turns
    wrong_zero,
    stops_not_reached, ///< so that zero and counts could not be checked by them
    test_aborted,      ///< by a limit of the board's
};

struct Finding {
    Problem problem = Problem::board_fault;
    std::optional<std::size_t> channel; ///< of motor, winding, sensor and encoder, from 0
    std::string what;                   ///< with the figures that show it
    std::string remedy;                 ///< what to look at, or to do
};

} // namespace springdrive::commissioning
