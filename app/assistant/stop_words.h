// What a person can do about a stop of the device, in words.
#pragma once

#include "device/core/board_faults.h"
#include "engine/servo/safety_status.h"

#include <array>
#include <cstdint>
#include <string>
#include <utility>

namespace springdrive::app::assistant {

/// Of the gravest of them.
[[nodiscard]] inline std::string remedy_of(device::BoardFaults faults) {
    using device::BoardFaults;
    static constexpr std::array<std::pair<std::uint16_t, const char *>, 10> kRemedies{{
        {BoardFaults::kStop, "release the stop switch, and look whether the enable line is closed"},
        {BoardFaults::kAmplifier,
         "switch the board's supply off and on; if it comes again, a power "
         "stage is damaged"},
        {BoardFaults::kSensor, "look at the plugs and the supply of the current sensors: one of "
                               "them measures nothing"},
        {BoardFaults::kSupply, "look at the supply and its leads: it must have the voltage that "
                               "the board is made for"},
        {BoardFaults::kTemperature, "let power stages and motors cool down, and look at the fan"},
        {BoardFaults::kHeat, "let the motors cool down for some minutes"},
        {BoardFaults::kOverCurrent, "look for a short circuit of a motor or its leads"},
        {BoardFaults::kEncoder, "look at the plugs and cables of the encoders"},
        {BoardFaults::kNoCommand, "commands came too late: a shorter cable, no hub; the doctor "
                                  "looks at this computer"},
        {BoardFaults::kOverrun, "the board's firmware is too slow: install another one"},
    }};
    for (const auto &[fault, remedy] : kRemedies) {
        if (faults.has(fault)) {
            return remedy;
        }
    }
    return "remove the cause";
}

/// What has to be done before the stop is reset.
[[nodiscard]] inline std::string remedy_of(const servo::SafetyStatus &stop) {
    using servo::TripCause;
    switch (stop.cause) {
    case TripCause::board_fault:
        return remedy_of(device::BoardFaults{static_cast<std::uint16_t>(stop.measured)});
    case TripCause::device_lost:
        return "it was unplugged, or its board restarted: look at its cable and supply";
    case TripCause::emergency_stop:
        return "look whether all is well";
    case TripCause::stale_measurement:
    case TripCause::missed_deadlines:
        return "a shorter cable, no hub; the doctor looks at this computer";
    case TripCause::motor_contradicted:
        return "look at the plugs and cables of motors and encoders: one of them is dead, or "
               "another's";
    case TripCause::tip_speed:
        return "move it more slowly";
    case TripCause::assertion:
        return "start the program again: nothing else resets this one";
    default:
        return "remove the cause";
    }
}

} // namespace springdrive::app::assistant
