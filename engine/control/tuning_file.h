// Tunings in files: assets/tunings/*.toml.
#pragma once

#include "engine/control/tuning.h"

#include <filesystem>

namespace springdrive {

/// Reads a tuning file: one key for each of `kParameters` by its name, `map` = "inverse" or
/// "transpose", `alpha_mode` = "on_the_fly", "global" or "by_hand", and a `description`.
/// @throw InputError naming the file, the line, the key and what it may be, for a file that cannot
///        be read, a missing or unknown key, or a value out of range.
[[nodiscard]] Tuning read_tuning_file(const std::filesystem::path &path);

} // namespace springdrive
