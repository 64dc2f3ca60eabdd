// Files and folders that are on the disk when a call returns.
#pragma once

#include <filesystem>

namespace springdrive::study {

/// Waits until a file, or the names in a folder, are on the disk.
/// @throw InputError if that fails
void sync(const std::filesystem::path &file_or_folder);

/// The same for the entries of all folders from a file's up to `top`.
void sync_folders(const std::filesystem::path &file, const std::filesystem::path &top);

/// Of a file that only this program makes, beside a study.
/// @throw InputError if something has its name that is no file of its own: a link of either kind, a
///        folder, a device
void check_own_file(const std::filesystem::path &file);

/// Removes a folder with all that is in it, and waits until it is gone from the disk. Links are
/// removed, not followed. Nothing is done if there is none.
/// @throw InputError if something cannot be removed
void remove_folder(const std::filesystem::path &folder);

} // namespace springdrive::study
