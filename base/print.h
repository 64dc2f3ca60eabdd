// Formatted text, for streams and for code that must not allocate.
#pragma once

#include <fmt/core.h>

#include <array>
#include <cstddef>
#include <ostream>
#include <type_traits>

namespace springdrive {

/// A libfmt format string, checked at compile time: libfmt rejects a wrong type and too few values,
/// this class also rejects too many.
template <typename... Values> class CheckedFormat {
public:
    /// Implicit, so that a call can pass a string literal.
    consteval CheckedFormat(const char *text) : format_(text) {
        if (fields_of(text) < sizeof...(Values)) {
            throw "more values than the format has fields";
        }
    }

    [[nodiscard]] fmt::string_view text() const { return format_; }

private:
    static consteval std::size_t fields_of(const char *text) {
        std::size_t fields = 0;
        for (; *text != '\0'; ++text) {
            if (text[0] == '{' && text[1] == '{') {
                ++text; // an escaped brace
            } else if (text[0] == '{') {
                ++fields; // a width or precision that is taken from the values counts, too
            }
        }
        return fields;
    }

    fmt::format_string<Values...> format_;
};

/// Prints formatted values; the format shows the columns of a table as they will look.
template <typename... Values>
void print(std::ostream &out, CheckedFormat<std::type_identity_t<Values>...> format,
           const Values &...values) {
    out << fmt::vformat(format.text(), fmt::make_format_args(values...));
}

/// The same into a buffer, without allocating: truncated to the buffer, always null-terminated.
template <std::size_t size, typename... Values>
void print(std::array<char, size> &text, CheckedFormat<std::type_identity_t<Values>...> format,
           const Values &...values) {
    static_assert(size > 0);
    const auto written =
        fmt::vformat_to_n(text.data(), size - 1, format.text(), fmt::make_format_args(values...));
    *written.out = '\0';
}

} // namespace springdrive
