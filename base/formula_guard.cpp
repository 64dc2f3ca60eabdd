#include "base/formula_guard.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace springdrive {

namespace {

bool begins_formula(std::string_view text) {
    constexpr std::array<std::string_view, 11> kBegins{"=",  "+",  "-",  "@",  "\t", "\r",
                                                       "\n", "＝", "＋", "－", "＠"};
    return std::ranges::any_of(kBegins,
                               [text](std::string_view begin) { return text.starts_with(begin); });
}

bool is_number(std::string_view text) {
    double number = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error != std::errc::invalid_argument && end == text.data() + text.size();
}

std::string_view after_quotes(std::string_view text) {
    return text.substr(std::min(text.find_first_not_of('\''), text.size()));
}

} // namespace

std::string guard_formula(std::string_view text) {
    const bool needs_it = begins_formula(after_quotes(text)) && !is_number(text);
    return (needs_it ? "'" : "") + std::string(text);
}

std::string unguard_formula(std::string_view guarded) {
    const bool has_it = guarded.starts_with('\'') && begins_formula(after_quotes(guarded));
    return std::string(guarded.substr(has_it ? 1 : 0));
}

} // namespace springdrive
