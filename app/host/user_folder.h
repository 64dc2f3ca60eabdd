// The user's folders for settings and state, by the XDG base directory specification.
#pragma once

#include <filesystem>

namespace springdrive::app {

/// An absolute folder that a variable of the environment names; else empty.
[[nodiscard]] std::filesystem::path folder_named_by(const char *variable);

/// The folder `springdrive` for files of one kind; empty where neither it nor the home is known.
/// @param variable  names the folder for all programs: "XDG_CONFIG_HOME"
/// @param in_home   without it: ".config"
[[nodiscard]] std::filesystem::path user_folder(const char *variable,
                                                const std::filesystem::path &in_home);

/// For session::SessionOptions::windings_folder.
[[nodiscard]] std::filesystem::path windings_folder();

} // namespace springdrive::app
