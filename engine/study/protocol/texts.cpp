#include "engine/study/protocol/texts.h"

#include "base/one_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace springdrive::study {

namespace {

/// "{}" and "{name}" of a text, in its order.
std::vector<std::string_view> placeholders_in(std::string_view text) {
    std::vector<std::string_view> found;
    for (std::size_t from = text.find('{'); from != std::string_view::npos;
         from = text.find('{', from + 1)) {
        const std::size_t to = text.find('}', from);
        if (to != std::string_view::npos) {
            found.push_back(text.substr(from, to + 1 - from));
        }
    }
    return found;
}

std::string wrong_placeholders(std::string_view key, std::string_view text,
                               std::string_view by_default) {
    const std::vector<std::string_view> needed = placeholders_in(by_default);
    const std::vector<std::string_view> found = placeholders_in(text);
    for (const std::string_view placeholder : needed) {
        if (const auto count = std::ranges::count(found, placeholder); count != 1) {
            return fmt::format("{} has {} {} times; it must have it once", key, placeholder, count);
        }
    }
    for (const std::string_view placeholder : found) {
        if (std::ranges::count(needed, placeholder) == 0) {
            return fmt::format("{} has {}, for which nothing is filled in; it must have {}{}", key,
                               in_quotes(placeholder),
                               needed.empty() ? "no text in braces"
                                              : "no other text in braces than ",
                               fmt::join(needed, " and "));
        }
    }
    return {};
}

} // namespace

std::string validate(const Texts &texts) {
    const Texts by_default;
    for (const Field<Texts> &field : kTextFields) {
        const auto text = std::get<std::string Texts::*>(field.member);
        if (std::string wrong = wrong_placeholders(field.name, texts.*text, by_default.*text);
            !wrong.empty()) {
            return wrong;
        }
    }
    return {};
}

std::string filled(std::string text, std::string_view placeholder, std::string_view value) {
    const std::size_t at = text.find(placeholder);
    return at == std::string::npos ? text : text.replace(at, placeholder.size(), value);
}

} // namespace springdrive::study
