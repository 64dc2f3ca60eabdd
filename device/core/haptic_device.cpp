#include "device/core/haptic_device.h"

#include <array>
#include <utility>

namespace springdrive::device {

std::string names_of(BoardFaults faults) {
    if (!faults.any()) {
        return "none";
    }
    constexpr std::array<std::pair<std::uint16_t, const char *>, 10> kNames{{
        {BoardFaults::kAmplifier, "an amplifier fault"},
        {BoardFaults::kOverCurrent, "overcurrent"},
        {BoardFaults::kTemperature, "overtemperature"},
        {BoardFaults::kSupply, "a supply voltage out of range"},
        {BoardFaults::kEncoder, "implausible encoder signals"},
        {BoardFaults::kNoCommand, "a command timeout"},
        {BoardFaults::kStop, "its stop switch, or its enable line open"},
        {BoardFaults::kHeat, "a winding too hot by its currents"},
        {BoardFaults::kSensor, "a failed current sensor"},
        {BoardFaults::kOverrun, "an amplifier loop that came late"},
    }};
    std::string text;
    for (const auto &[fault, name] : kNames) {
        if (faults.has(fault)) {
            text += (text.empty() ? "" : ", ") + std::string(name);
        }
    }
    return text.empty() ? "an unknown fault" : text;
}

} // namespace springdrive::device
