// The location of devices, tunings, scenes and the figures' scripts.
#pragma once

#include <filesystem>

namespace springdrive::app {

/// $SPRINGDRIVE_ASSETS, or that of the running program.
[[nodiscard]] std::filesystem::path asset_folder();

/// Of an installed program ../share/springdrive beside its folder, wherever that was moved; else
/// the folder that it was built with.
[[nodiscard]] std::filesystem::path assets_of(const std::filesystem::path &program);

} // namespace springdrive::app
