// Formatted text, for streams and for where nothing may be allocated.
#pragma once

#include <fmt/core.h>

#include <array>
#include <cstddef>
#include <iosfwd>
#include <string>
#include <string_view>
#include <type_traits>

namespace springdrive {

/// How values are to be written, as libfmt has it. What does not fit does not compile: libfmt
/// refuses a value of the wrong type and one too few, this one too many.
template <typename... Values> class CheckedFormat {
public:
    /// Implicit: from the literal at the call.
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
                ++text; // a brace that is written
            } else if (text[0] == '{') {
                ++fields; // a width or precision among the values, too
            }
        }
        return fields;
    }

    fmt::format_string<Values...> format_;
};

/// What print calls once its format has been checked.
void print_checked(std::ostream &out, fmt::string_view format, fmt::format_args values);

/// A table's columns stay readable in the code that makes them.
template <typename... Values>
void print(std::ostream &out, CheckedFormat<std::type_identity_t<Values>...> format,
           const Values &...values) {
    print_checked(out, format.text(), fmt::make_format_args(values...));
}

/// The same into a buffer, without allocating: cut off where the buffer ends, always terminated.
template <std::size_t size, typename... Values>
void print(std::array<char, size> &text, CheckedFormat<std::type_identity_t<Values>...> format,
           const Values &...values) {
    static_assert(size > 0);
    const auto written =
        fmt::vformat_to_n(text.data(), size - 1, format.text(), fmt::make_format_args(values...));
    *written.out = '\0';
}

/// Text as one cell of a CSV file: in quotes where it needs them.
[[nodiscard]] std::string csv_cell(std::string_view text);

/// The fewest digits that give the same number again; empty where it is infinite or none.
[[nodiscard]] std::string csv_cell(double number);

} // namespace springdrive
