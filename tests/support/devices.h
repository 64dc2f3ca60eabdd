// Devices that several tests share.
#pragma once

#include "device/core/device_file.h"

#include <filesystem>
#include <ostream>

namespace springdrive::device {

/// For GoogleTest, which would print its bytes.
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

} // namespace springdrive::testing
