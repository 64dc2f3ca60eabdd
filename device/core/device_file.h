// Reads a device's description from assets/devices/*.toml.
#pragma once

#include "device/core/device_description.h"

#include <filesystem>
#include <string>

namespace springdrive::device {

/// Reads a device file.
/// @throw InputError naming the file, the line, the key, the value and its allowed range: for a
///        file that cannot be read or parsed, a missing or unknown key, a value of the wrong type,
///        not finite or out of range.
[[nodiscard]] DeviceDescription read_device_file(const std::filesystem::path &path);

/// Parses a device file's text, e.g. from a record; error messages refer to it as `path`.
[[nodiscard]] DeviceDescription read_device_text(const std::string &text,
                                                 const std::filesystem::path &path);

} // namespace springdrive::device
