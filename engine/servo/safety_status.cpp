#include "engine/servo/safety_status.h"

#include "base/degrees.h"
#include "device/core/haptic_device.h"

#include <fmt/core.h>

#include <array>
#include <cstdint>
#include <utility>

namespace springdrive::servo {

namespace {

/// How to display a measured value and its limit.
struct Wording {
    const char *what = nullptr;
    const char *unit = nullptr;
    int decimals = 0;
    double shown_per_si = 1.0;
};

std::string crossed(const SafetyStatus &status, const Wording &wording) {
    return fmt::format("{} {:.{}f}{}, limit {:.{}f}{}", wording.what,
                       wording.shown_per_si * status.measured, wording.decimals, wording.unit,
                       wording.shown_per_si * status.limit, wording.decimals, wording.unit);
}

/// A record holds the cause without the location.
std::string text_of(const AssertionFailure &failure) {
    return failure.condition == nullptr
               ? "internal error; restart the program"
               : fmt::format("internal error, assertion failed at {}:{}: {}; restart the program",
                             failure.file, failure.line, failure.condition);
}

std::string cause_text(const SafetyStatus &status) {
    switch (status.cause) {
    case TripCause::none:
        return "no trip";
    case TripCause::emergency_stop:
        return "emergency stop";
    case TripCause::device_lost:
        return "the device does not answer";
    case TripCause::board_fault:
        return "the device's board reports " +
               names_of(device::BoardFaults{static_cast<std::uint16_t>(status.measured)});
    case TripCause::stale_measurement:
        return crossed(status, {"no fresh measurement for", " ms", 1, 1e3});
    case TripCause::not_finite:
        return "a value is not finite";
    case TripCause::torn_inputs:
        return "parameters arrived incomplete";
    case TripCause::missed_deadlines:
        return crossed(status, {"consecutive deadlines missed for", " ms", 1, 1e3});
    case TripCause::window_silent:
        return crossed(status, {"no heartbeat from the window for", " s", 2});
    case TripCause::encoder_jump:
        return crossed(status, {"encoder jump at the tip", " mm", 2, 1e3});
    case TripCause::motor_contradicted:
        return crossed(status, {"current and encoder of a motor contradict each other by", "°", 1,
                                kDegreesPerRadian});
    case TripCause::current:
        return crossed(status, {"winding current", " A", 2});
    case TripCause::tip_force:
        return crossed(status, {"tip force", " N", 2});
    case TripCause::tip_speed:
        return crossed(status, {"tip speed", " m/s", 2});
    case TripCause::winding_temperature:
        return crossed(status, {"winding temperature, upper estimate,", " °C", 1});
    case TripCause::beyond_stops:
        return crossed(status, {"joint angle beyond its stop by", "°", 1, kDegreesPerRadian});
    case TripCause::energy:
        return crossed(status, {"energy delivered to the hand", " mJ", 1, 1e3});
    case TripCause::voltage:
        return crossed(status, {"sustained e_W", " V", 1});
    case TripCause::assertion:
        return text_of(status.failure);
    }
    return "unknown";
}

} // namespace

std::string description(const SafetyStatus &status) {
    const bool is_by_switch = status.cause == TripCause::board_fault &&
                              device::BoardFaults{static_cast<std::uint16_t>(status.measured)}.has(
                                  device::BoardFaults::kStop);
    const bool says_stop = status.cause == TripCause::emergency_stop || is_by_switch;
    return cause_text(status) +
           (status.held_stop != 0 && !says_stop ? "; then it was stopped by hand" : "");
}

} // namespace springdrive::servo
