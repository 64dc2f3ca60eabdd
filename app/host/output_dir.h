// Where the window puts what its user makes without naming a file: kept sessions, records, tunings,
// exported plots. Files that are named on the command line are where they are named.
#pragma once

#include <filesystem>
#include <string>

namespace springdrive::app {

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
