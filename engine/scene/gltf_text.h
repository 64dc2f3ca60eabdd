// Text out of a file that others wrote, made fit for a one-line message.
#pragma once

#include <string>
#include <string_view>

namespace springdrive::scene::gltf {

/// `text` on one line: control characters and line ends become single spaces, the ends are
/// trimmed, and what is longer than `max_length` bytes is cut (never within a UTF-8 character).
[[nodiscard]] std::string one_line(std::string_view text, std::size_t max_length = 300);

/// `text` on one line, in single quotes.
[[nodiscard]] std::string in_quotes(std::string_view text);

/// The shortest text that reads back as `number`.
[[nodiscard]] std::string shortest(double number);

} // namespace springdrive::scene::gltf
