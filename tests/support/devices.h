// Devices that several tests share.
#pragma once

#include "base/vector.h"
#include "device/core/device_file.h"

#include <filesystem>
#include <ostream>

namespace springdrive::device {

/// For GoogleTest, which would otherwise print its bytes.
inline void PrintTo(const DeviceDescription &device, std::ostream *out) { *out << device.name; }

} // namespace springdrive::device

namespace springdrive::testing {

inline std::filesystem::path assets() { return SPRINGDRIVE_ASSET_DIR; }

inline device::DeviceDescription phantom_1_0() {
    return device::read_device_file(assets() / "devices/phantom_1_0.toml");
}
inline device::DeviceDescription phantom_premium_1_5() {
    return device::read_device_file(assets() / "devices/phantom_premium_1_5.toml");
}

/// The first motor of the PHANTOM 1.0; its three motors are identical.
inline const device::MotorParameters &phantom_motor() {
    static const device::MotorParameters read = phantom_1_0().motor[0];
    return read;
}

/// A position in its workspace where nothing is zero or symmetrical.
inline const Vector3 kOffCentre_m(0.02, 0.03, 0.01);

} // namespace springdrive::testing
