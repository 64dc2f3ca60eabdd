// Limits that the safety monitor enforces, which the device file sets and the operator may lower,
// and the soft wall at the edge of the workspace.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"

#include <array>
#include <cstddef>
#include <limits>
#include <string_view>

namespace springdrive::servo {

/// Each is the value that must not be exceeded. Where motors differ this is the largest of their
/// limits; each motor's own limit applies as well.
struct SafetyLimits {
    double voltage_V = 0.0;          ///< e_W at an amplifier; clamped
    double current_A = 0.0;          ///< measured in a winding
    double winding_C = 0.0;          ///< upper estimate of a winding's temperature
    double tip_force_N = 0.0;        ///< rendered force, J⁻ᵀ k_T i
    double tip_speed_m_per_s = 0.0;  ///< J θ̇_f
    double beyond_stops_rad = 0.0;   ///< of joint angles beyond the linkage's stops
    double generated_energy_J = 0.0; ///< delivered to the hand beyond what it put in
    double late_s = 0.0;             ///< of consecutive missed deadlines
    double stale_s = 0.0;            ///< since the last fresh measurement
    double window_silence_s = 0.0;   ///< since the last heartbeat of the window
};

/// A limit and its name.
struct SafetyLimit {
    const char *name; ///< with unit, as in files and CSV headers
    const char *what; ///< for display
    const char *unit;
    double SafetyLimits::*value;
    double shown_per_si; ///< displayed value per SI unit
};

/// The list of all limits, read by panel, record and tests.
inline constexpr std::array<SafetyLimit, 10> kSafetyLimits{{
    {"voltage_V", "voltage e_W", "V", &SafetyLimits::voltage_V, 1.0},
    {"current_A", "winding current", "A", &SafetyLimits::current_A, 1.0},
    {"winding_C", "winding temperature", "°C", &SafetyLimits::winding_C, 1.0},
    {"tip_force_N", "tip force", "N", &SafetyLimits::tip_force_N, 1.0},
    {"tip_speed_m_per_s", "tip speed", "m/s", &SafetyLimits::tip_speed_m_per_s, 1.0},
    {"beyond_stops_rad", "beyond the stops", "°", &SafetyLimits::beyond_stops_rad,
     57.29577951308232},
    {"generated_energy_J", "generated energy", "mJ", &SafetyLimits::generated_energy_J, 1e3},
    {"late_s", "deadlines missed for", "ms", &SafetyLimits::late_s, 1e3},
    {"stale_s", "no fresh measurement for", "ms", &SafetyLimits::stale_s, 1e3},
    {"window_silence_s", "no window heartbeat for", "s", &SafetyLimits::window_silence_s, 1.0},
}};

/// The limits set by the device file.
[[nodiscard]] SafetyLimits limits_of(const device::DeviceDescription &device);

/// Requests no lowering: infinite values.
[[nodiscard]] constexpr SafetyLimits unlowered() {
    SafetyLimits none;
    for (const SafetyLimit &limit : kSafetyLimits) {
        none.*limit.value = std::numeric_limits<double>::infinity();
    }
    return none;
}

/// The smaller value of each limit; a requested value that is not positive is ignored. RT-safe.
[[nodiscard]] SafetyLimits lowered(const SafetyLimits &device,
                                   const SafetyLimits &request) noexcept;

// The soft wall at the edge of the workspace: before each joint's stop, and before the links fold
// too far, a spring and a damper push back. They act directly on the motor torque, so no tuning
// disables them.

/// How far joint angles are beyond limits reduced by `margin_rad`: the joints, and the fold q₃ −
/// q₂. Positive beyond the upper limit, negative beyond the lower, zero within [rad].
struct BeyondLimits {
    Vector3 joint_rad{Vector3::Zero()};
    double fold_rad = 0.0;

    [[nodiscard]] double max_excess_rad() const noexcept;
};

/// RT-safe.
[[nodiscard]] BeyondLimits beyond_limits(const device::JointLimits &limits, const Vector3 &q_rad,
                                         double margin_rad) noexcept;

/// Joint torques of the soft wall [N·m]; zero within. RT-safe.
[[nodiscard]] Vector3 edge_torque_Nm(const device::DeviceDescription &device, const Vector3 &q_rad,
                                     const Vector3 &q_rate_rad_per_s) noexcept;

} // namespace springdrive::servo
