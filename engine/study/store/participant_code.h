// A participant's code, which stands for a person whose name is not stored.
#pragma once

#include <string>
#include <string_view>

namespace springdrive::study {

/// Why a text is no participant's code; empty when it is one. A code is one to three capital
/// letters, one to four digits and nothing else, such as P01: a name cannot be typed by mistake.
[[nodiscard]] std::string validate_code(std::string_view code);

/// Whether a text has the code, in letters of either case and not as a part of another code:
/// "p01, left-handed" has P01; "P012" and "XP01" have not.
[[nodiscard]] bool has_code(std::string_view text, std::string_view code);

/// Puts "[removed]" in the place of the code. @return whether the text had it, see `has_code`
bool redact_code(std::string &text, std::string_view code);

} // namespace springdrive::study
