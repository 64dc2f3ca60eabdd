// What a haptic device is, as read from assets/devices/*.toml: data live there, not in code.
#pragma once

#include "base/vector.h"
#include "device/motor/motor.h"
#include "device/phantom/geometry.h"

#include <array>
#include <filesystem>
#include <string>

namespace springdrive {

/// A box in which the device moves comfortably; scenes are fitted into it.
struct Workspace {
    Vector3 centre_m{Vector3::Zero()};
    Vector3 size_m{Vector3::Zero()};
};

/// What the safety monitor holds to. No panel or option raises these.
struct DeviceLimits {
    double tip_force_N = 0.0;       ///< rendered force above which the monitor trips
    double tip_speed_m_per_s = 0.0; ///< tip speed above which the monitor trips
};

struct DeviceDescription {
    std::string name;
    PhantomGeometry geometry;
    std::array<MotorParameters, 3> motor;
    int encoder_counts_per_turn = 0;        ///< of the motor shaft, after ×4
    double joint_damping_Nms_per_rad = 0.0; ///< viscous, at each joint
    double tip_mass_kg = 0.0;               ///< apparent mass at the tip, without the rotors
    Workspace workspace;
    DeviceLimits limits;
};

/// Reads a device file.
/// @throw InputError naming the file, the line, the key, the value and its allowed range: for a
///        file that cannot be read or parsed, a missing or unknown key, a value of the wrong type,
///        not finite or out of range.
[[nodiscard]] DeviceDescription read_device_file(const std::filesystem::path &path);

} // namespace springdrive
