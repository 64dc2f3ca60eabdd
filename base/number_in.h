// Numbers in texts.
#pragma once

#include <charconv>
#include <optional>
#include <string_view>

namespace springdrive {

/// All of a text as a number; nothing for any other text, or a number that the type cannot hold.
template <typename Number> [[nodiscard]] std::optional<Number> number_in(std::string_view text) {
    Number number{};
    const char *const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, number);
    return error == std::errc() && stop == end ? std::optional(number) : std::nullopt;
}

} // namespace springdrive
