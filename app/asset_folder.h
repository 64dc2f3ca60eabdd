// The location of devices, tunings and scenes.
#pragma once

#include <filesystem>

namespace springdrive::app {

/// $SPRINGDRIVE_ASSETS, or the folder beside the sources.
[[nodiscard]] std::filesystem::path asset_folder();

} // namespace springdrive::app
