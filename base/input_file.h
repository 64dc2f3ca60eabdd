// Files that the program reads: what is checked before one is read as a whole, and paths that a
// file names, which stay inside its folder, whoever wrote the file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace springdrive {

/// Checks a file before it is read as a whole. Does not open it: a pipe would wait for its writer,
/// and a device need not end.
/// @param kind  what to name in its place, such as "a TOML file"
/// @throw InputError, with the file's name, for what is a folder, no ordinary file or larger than
///        `max_bytes`. One that does not exist is left to who opens it.
void check_input_file(const std::filesystem::path &file, std::string_view kind,
                      std::uintmax_t max_bytes);

/// Why a text is no name of a file or folder; empty if it is one: not empty, "." or "..", of up to
/// 255 bytes, and without slashes and control characters.
[[nodiscard]] std::string validate_file_name(std::string_view name);

/// The file that `path` leads to from `folder`, with all links followed; it need not exist.
/// @param of  what names it, as "scene": "lies outside the scene's folder"
/// @throw InputError, which does not name the file, for a path that is absolute or has control
///        characters, and for one that leads out of the folder, also by way of a link.
[[nodiscard]] std::filesystem::path
contained_file(std::string_view path, const std::filesystem::path &folder, std::string_view of);

/// `folder / relative`, of which nothing below the folder is a link.
/// @throw InputError otherwise, and if a part of `relative` is no name of a file
[[nodiscard]] std::filesystem::path path_without_links(const std::filesystem::path &folder,
                                                       const std::filesystem::path &relative);

} // namespace springdrive
