// Devices that several tests share.
#pragma once

#include "device/device_file.h"

#include <filesystem>
#include <ostream>

namespace springdrive {

/// For GoogleTest, which would print its bytes.
inline void PrintTo(const DeviceDescription &device, std::ostream *out) { *out << device.name; }

} // namespace springdrive

namespace springdrive::testing {

inline std::filesystem::path assets() { return SPRINGDRIVE_ASSET_DIR; }

inline DeviceDescription phantom_1_0() {
    return read_device_file(assets() / "devices/phantom_1_0.toml");
}
inline DeviceDescription phantom_premium_1_5() {
    return read_device_file(assets() / "devices/phantom_premium_1_5.toml");
}

} // namespace springdrive::testing
