// Protocols in files: assets/protocols/*.toml, and those of researchers. docs/study_protocol.md has
// every key.
#pragma once

#include "engine/study/protocol/protocol.h"

#include <filesystem>
#include <iosfwd>
#include <string>

namespace springdrive::study {

/// @throw InputError naming the file, the line, the key, its value and what is allowed, for a file
///        that cannot be read, is no TOML, has an unknown key (with the nearest one that is known),
///        lacks one, or has a value of the wrong type or out of its range.
[[nodiscard]] Protocol read_protocol_file(const std::filesystem::path &file);

/// The same from a text, such as the one that a study keeps; messages refer to it as `file`.
[[nodiscard]] Protocol read_protocol_text(const std::string &text,
                                          const std::filesystem::path &file);

/// Every key that a protocol file may have, as Markdown tables in the order of the manual.
void write_protocol_keys(std::ostream &out);

} // namespace springdrive::study
