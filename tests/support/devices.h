// Devices that several tests share.
#pragma once

#include "base/vector.h"
#include "device/core/device_file.h"

#include <filesystem>
#include <fstream>
#include <ostream>
#include <sstream>
#include <string>

namespace springdrive::device {

/// For GoogleTest, which would otherwise print its bytes.
inline void PrintTo(const DeviceDescription &device, std::ostream *out) { *out << device.name; }

} // namespace springdrive::device

namespace springdrive::testing {

inline std::filesystem::path assets() { return SPRINGDRIVE_ASSET_DIR; }

inline device::DeviceDescription phantom_1_0() {
    return device::read_device_file(assets() / "devices/phantom_1_0.toml");
}

/// phantom_1_0.toml in that folder, with motors that are known to have no V_b. Returns its path.
inline std::filesystem::path write_phantom_without_brushes(const std::filesystem::path &folder) {
    std::stringstream text;
    text << std::ifstream(assets() / "devices/phantom_1_0.toml").rdbuf();
    std::string changed = text.str();
    const std::string brushes = "greatest_brush_voltage_V = 0.5";
    changed.replace(changed.find(brushes), brushes.size(), "greatest_brush_voltage_V = 0.0");
    const std::filesystem::path file = folder / "without_brushes.toml";
    std::ofstream(file) << changed;
    return file;
}

/// One whose motors are known to have no V_b: a touch then tells R at once.
inline device::DeviceDescription phantom_without_brushes() {
    device::DeviceDescription device = phantom_1_0();
    for (device::MotorParameters &motor : device.motor) {
        motor.max_brush_voltage_V = 0.0;
    }
    return device;
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
