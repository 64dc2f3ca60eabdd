// Texts in tables that are opened with a spreadsheet, which runs what begins like a formula.
#pragma once

#include <string>
#include <string_view>

namespace springdrive {

/// What begins with = + - @, also of full width, with a tab or a line end, and is no number, has a
/// ' in front, as people type it there; so has what begins so after other '.
[[nodiscard]] std::string guard_formula(std::string_view text);

/// What `guard_formula` was given.
[[nodiscard]] std::string unguard_formula(std::string_view guarded);

} // namespace springdrive
