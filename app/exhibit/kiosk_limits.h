// Limits of the safety monitor at an exhibit, where anybody may hold the device.
#pragma once

#include "engine/servo/safety_limits.h"

namespace springdrive::app::exhibit {

/// They are set before the servo starts, and nothing in a kiosk's window changes them. A limit of
/// the device's file that is lower still counts; all others are those of the file.
[[nodiscard]] constexpr servo::SafetyLimits kiosk_limits() {
    servo::SafetyLimits limits = servo::unlowered();
    limits.voltage_V = 9.0;
    limits.current_A = 4.0;
    limits.tip_force_N = 5.0;
    limits.tip_speed_m_per_s = 1.2;
    limits.winding_C = 90.0;
    return limits;
}

} // namespace springdrive::app::exhibit
