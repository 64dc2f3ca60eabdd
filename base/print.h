// printf for streams.
#pragma once

#include <cstdarg>
#include <cstdio>
#include <ostream>
#include <string>

namespace springdrive {

/// A table's columns stay readable in the code that makes them. The compiler holds the values
/// against the format.
[[gnu::format(printf, 2, 3)]] inline void print(std::ostream &out, const char *format, ...) {
    std::va_list values;
    va_start(values, format);
    std::va_list again;
    va_copy(again, values);
    std::string text(static_cast<std::size_t>(std::vsnprintf(nullptr, 0, format, values)), '\0');
    va_end(values);
    std::vsnprintf(text.data(), text.size() + 1, format, again); // its closing zero is the string's
    va_end(again);
    out << text;
}

} // namespace springdrive
