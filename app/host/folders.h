// Folders of this computer: of what the program is installed with, of the user's settings and state
// by the XDG base directory specification, and where the window puts what its user makes without
// naming a file: kept sessions, records, tunings, exported plots. Files that are named on the
// command line are where they are named.
#pragma once

#include <filesystem>
#include <string>

namespace springdrive::app {

/// $SPRINGDRIVE_ASSETS, or that of the running program.
[[nodiscard]] std::filesystem::path asset_folder();

/// Of an installed program ../share/springdrive beside its folder, wherever that was moved; else
/// the folder that it was built with.
[[nodiscard]] std::filesystem::path assets_of(const std::filesystem::path &program);

/// An absolute folder that a variable of the environment names; else empty.
[[nodiscard]] std::filesystem::path folder_named_by(const char *variable);

/// The folder `springdrive` for files of one kind; empty where neither it nor the home is known.
/// @param variable  names the folder for all programs: "XDG_CONFIG_HOME"
/// @param in_home   without it: ".config"
[[nodiscard]] std::filesystem::path user_folder(const char *variable,
                                                const std::filesystem::path &in_home);

/// For session::SessionOptions::windings_folder.
[[nodiscard]] std::filesystem::path windings_folder();

/// ".", the folder where the program was started. If that is the home folder or the root, as from
/// a menu, or cannot be written to: `springdrive` in the user's folder of documents. It need not
/// exist. The same for as long as the program runs.
[[nodiscard]] const std::filesystem::path &output_dir();

/// For display: "the folder where springdrive was started", or its name.
[[nodiscard]] std::string output_dir_text();

/// A file of that name in the own folder, which is made if it does not exist.
[[nodiscard]] std::filesystem::path in_output_dir(const std::string &name);

/// What `output_dir` would be if it was asked for the first time now.
[[nodiscard]] std::filesystem::path choose_output_dir();

/// XDG_DOCUMENTS_DIR of user-dirs.dirs, if that folder exists, else `home`.
/// @param settings  the user's user-dirs.dirs; it may be missing
[[nodiscard]] std::filesystem::path documents_folder(const std::filesystem::path &settings,
                                                     const std::filesystem::path &home);

} // namespace springdrive::app
