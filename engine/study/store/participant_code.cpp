#include "engine/study/store/participant_code.h"

#include "base/one_line.h"

#include <algorithm>

namespace springdrive::study {

namespace {

constexpr std::string_view kReplacement = "[removed]";

bool is_capital(char c) { return c >= 'A' && c <= 'Z'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

bool is_same_letter(char typed, char of_code) {
    return typed == of_code || (is_capital(of_code) && typed == of_code - 'A' + 'a');
}

/// Where the code stands next, from `begin` on; npos if it does not.
std::size_t find_code(std::string_view text, std::string_view code, std::size_t begin) {
    for (std::size_t at = begin; at + code.size() <= text.size(); ++at) {
        if (!std::ranges::equal(text.substr(at, code.size()), code, is_same_letter)) {
            continue;
        }
        std::size_t first = at;
        while (first > 0 && is_capital(text[first - 1])) {
            --first;
        }
        std::size_t end = at + code.size();
        while (end < text.size() && is_digit(text[end])) {
            ++end;
        }
        const std::string_view longest = text.substr(first, end - first);
        if (longest.size() == code.size() || !validate_code(longest).empty()) {
            return at;
        }
    }
    return std::string_view::npos;
}

} // namespace

std::string validate_code(std::string_view code) {
    const auto digits = std::ranges::find_if_not(code, is_capital);
    const auto letters_count = digits - code.begin();
    const auto digits_count = code.end() - digits;
    const bool is_code = letters_count >= 1 && letters_count <= 3 && digits_count >= 1 &&
                         digits_count <= 4 && std::all_of(digits, code.end(), is_digit);
    return is_code
               ? std::string()
               : in_quotes(code) + " is no participant's code: one to three capital letters and "
                                   "one to four digits, as P01; names are not stored";
}

bool has_code(std::string_view text, std::string_view code) {
    return find_code(text, code, 0) != std::string_view::npos;
}

bool redact_code(std::string &text, std::string_view code) {
    bool had_it = false;
    for (std::size_t at = find_code(text, code, 0); at != std::string::npos;
         at = find_code(text, code, at + kReplacement.size())) {
        text.replace(at, code.size(), kReplacement);
        had_it = true;
    }
    return had_it;
}

} // namespace springdrive::study
