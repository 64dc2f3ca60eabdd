// Writes files and standard output. Nothing is overwritten unasked.
#pragma once

#include "base/new_file.h"

#include <filesystem>
#include <functional>
#include <ostream>
#include <string>

namespace springdrive::app {

using Writer = std::function<void(std::ostream &)>;

/// A file that is not an open one of this process, such as /dev/stdout sent to a file: it appears
/// under its name when it is complete.
[[nodiscard]] bool appears_complete(const std::filesystem::path &resolved);

/// Lets `write` fill the file, or standard output where `where` is "-". A regular file appears when
/// it is complete.
/// @throw InputError if the file exists and is to be kept, or cannot be created or written
///        completely; an existing one is then as it was.
void write_output(const std::string &where, const Writer &write, FilePolicy policy);

/// A new file. Returns what came of it, for display: "saved as mine.toml", or why not.
[[nodiscard]] std::string save_as(const std::filesystem::path &file, const Writer &write);

} // namespace springdrive::app
