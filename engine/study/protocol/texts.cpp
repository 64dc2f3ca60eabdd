#include "engine/study/protocol/texts.h"

#include "base/one_line.h"

#include <fmt/core.h>

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

std::string wrong_placeholders(const ParticipantText &one, std::string_view text) {
    const std::vector<std::string_view> found = placeholders_in(text);
    for (const std::string_view placeholder : one.placeholders) {
        const auto count = std::ranges::count(found, placeholder);
        if (!placeholder.empty() && count != 1) {
            return fmt::format("{} has {} {} times; it must have it once", one.key, placeholder,
                               count);
        }
    }
    for (const std::string_view placeholder : found) {
        if (std::ranges::count(one.placeholders, placeholder) == 0) {
            return fmt::format(
                "{} has {}, for which nothing is filled in; it must have {}", one.key,
                in_quotes(placeholder),
                one.placeholders[0].empty()
                    ? "no text in braces"
                    : fmt::format("no other text in braces than {}{}{}", one.placeholders[0],
                                  one.placeholders[1].empty() ? "" : " and ", one.placeholders[1]));
        }
    }
    return {};
}

} // namespace

std::string what_is_wrong_with(const Texts &texts) {
    for (const ParticipantText &one : kParticipantTexts) {
        if (std::string wrong = wrong_placeholders(one, texts.*one.text); !wrong.empty()) {
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
