// Checks a file before it is read as a whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace springdrive {

/// Does not open it: a pipe would wait for its writer, and a device need not end.
/// @param kind  what to name in its place, such as "a TOML file"
/// @throw InputError, with the file's name, for what is a folder, no ordinary file or larger than
///        `max_bytes`. One that does not exist is left to who opens it.
void check_input_file(const std::filesystem::path &file, std::string_view kind,
                      std::uintmax_t max_bytes);

} // namespace springdrive
