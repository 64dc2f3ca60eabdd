// How fast a folder takes what a record writes.
#pragma once

#include "app/doctor/trial.h"

#include <cstddef>
#include <filesystem>

namespace springdrive::app::doctor {

/// Writes for some 0.4 s to a file without a name, which goes with this process.
/// @param second_bytes  of a record: written before each synchronisation
[[nodiscard]] DiskTrial try_disk(const std::filesystem::path &folder, std::size_t second_bytes);

} // namespace springdrive::app::doctor
