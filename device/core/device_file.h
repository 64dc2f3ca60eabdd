// Reads a device's description from assets/devices/*.toml, with its [calibration]: which numbers of
// that are possible, and how they are written.
#pragma once

#include "base/field.h"
#include "device/core/device_description.h"

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace springdrive::device {

/// Reads a device file.
/// @throw InputError naming the file, the line, the key, the value and its allowed range: for a
///        file that cannot be read or parsed, a missing or unknown key, a value of the wrong type,
///        not finite or out of range.
[[nodiscard]] DeviceDescription read_device_file(const std::filesystem::path &path);

/// Parses a device file's text, e.g. from a record; error messages refer to it as `path`.
[[nodiscard]] DeviceDescription read_device_text(const std::string &text,
                                                 const std::filesystem::path &path);

/// A number of a motor's calibration: its key, and which values are possible.
struct CalibrationField {
    std::string_view key;
    double MotorCalibration::*value = nullptr;
    NumberRange range;
};

inline constexpr std::size_t kCalibrationFields = 16;
/// From this one on they are of the brushes: all of them are given, or, as in calibrations of
/// before, none and all are 0.
inline constexpr std::size_t kFirstBrushField = 12;

/// In the order of file and board. R and k_T must be within the tolerances of the device's kind,
/// or it is another motor.
/// @param air_error_K  by which the air may have been warmer or colder than the calibration says
[[nodiscard]] std::array<CalibrationField, kCalibrationFields>
calibration_fields(const DeviceDescription &device, std::size_t motor, double air_error_K);

/// Empty, or in one line which number is impossible for this kind of device, and its range.
[[nodiscard]] std::string validate(const Calibration &calibration, const DeviceDescription &device);

/// A device file's text with this calibration, instead of any that it has.
[[nodiscard]] std::string with_calibration(const std::string &device_text,
                                           const Calibration &calibration);

/// @throw InputError if the device has a calibration of another serial number
void require_calibration_of(const DeviceDescription &device, const std::string &serial);

} // namespace springdrive::device
