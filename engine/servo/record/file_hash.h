// Which file it was: its SHA-256, kept in records so that a replay can tell another scene.
#pragma once

#include <filesystem>
#include <string>

namespace springdrive {

/// 64 digits, lower-case hex, as sha256sum prints it.
/// @throw InputError for a file that cannot be read.
[[nodiscard]] std::string sha256_of_file(const std::filesystem::path &file);

} // namespace springdrive
