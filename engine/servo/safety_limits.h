// What the safety monitor holds to. The device file sets it; whoever runs the device may lower it.
#pragma once

#include "device/core/device_file.h"

#include <array>
#include <cstddef>
#include <limits>
#include <string_view>

namespace springdrive::servo {

/// Each is the value that must not be passed. One that differs between motors is here that of the
/// motor that bears most; every motor's own still holds for it.
struct SafetyLimits {
    double voltage_V = 0.0;          ///< e_W at an amplifier; more is not passed on
    double current_A = 0.0;          ///< measured in a winding
    double winding_C = 0.0;          ///< upper estimate of a winding's temperature
    double tip_force_N = 0.0;        ///< rendered, J⁻ᵀ k_T i
    double tip_speed_m_per_s = 0.0;  ///< J θ̇_f
    double beyond_stops_rad = 0.0;   ///< of joint angles beyond the linkage's stops
    double generated_energy_J = 0.0; ///< given to the hand beyond what it had put in
    double late_s = 0.0;             ///< by deadlines missed in a row
    double stale_s = 0.0;            ///< since the last fresh measurement
    double window_silence_s = 0.0;   ///< since the last sign of life of the window
};

/// One of them, by name.
struct SafetyLimit {
    const char *name; ///< with its unit: in files and CSV headers
    const char *what; ///< for people
    const char *unit;
    double SafetyLimits::*value;
    double shown_per_si; ///< what a panel shows per SI unit
};

/// The one list of limits: panel, record and tests read it.
inline constexpr std::array<SafetyLimit, 10> kSafetyLimits{{
    {"voltage_V", "voltage e_W", "V", &SafetyLimits::voltage_V, 1.0},
    {"current_A", "winding current", "A", &SafetyLimits::current_A, 1.0},
    {"winding_C", "winding temperature", "°C", &SafetyLimits::winding_C, 1.0},
    {"tip_force_N", "tip force", "N", &SafetyLimits::tip_force_N, 1.0},
    {"tip_speed_m_per_s", "tip speed", "m/s", &SafetyLimits::tip_speed_m_per_s, 1.0},
    {"beyond_stops_rad", "beyond the stops", "°", &SafetyLimits::beyond_stops_rad,
     57.29577951308232},
    {"generated_energy_J", "generated energy", "mJ", &SafetyLimits::generated_energy_J, 1e3},
    {"late_s", "deadlines missed in a row", "ms", &SafetyLimits::late_s, 1e3},
    {"stale_s", "no fresh measurement for", "ms", &SafetyLimits::stale_s, 1e3},
    {"window_silence_s", "silence of the window", "s", &SafetyLimits::window_silence_s, 1.0},
}};

/// What the device file allows.
[[nodiscard]] SafetyLimits limits_of(const device::DeviceDescription &device);

/// Nothing lowered: any limit of a device is below.
[[nodiscard]] constexpr SafetyLimits unlowered() {
    SafetyLimits none;
    for (const SafetyLimit &limit : kSafetyLimits) {
        none.*limit.value = std::numeric_limits<double>::infinity();
    }
    return none;
}

/// The lesser of the two, one by one; a wish that is not a positive number changes nothing.
/// RT-safe.
[[nodiscard]] SafetyLimits lowered(const SafetyLimits &device, const SafetyLimits &wish) noexcept;

} // namespace springdrive::servo
