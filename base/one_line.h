// Text and numbers as parts of a one-line message or file entry.
#pragma once

#include <string>
#include <string_view>

namespace springdrive {

/// `text` on one line: control characters and line ends become single spaces, the ends are
/// trimmed, and what is longer than `max_length` bytes is cut (never within a UTF-8 character).
[[nodiscard]] std::string one_line(std::string_view text, std::size_t max_length = 300);

/// `text` on one line, in single quotes.
[[nodiscard]] std::string in_quotes(std::string_view text);

/// The shortest text that reads back as `number`.
[[nodiscard]] std::string shortest_text(double number);

} // namespace springdrive
