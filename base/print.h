// printf for streams.
#pragma once

#include <cstdio>
#include <ostream>
#include <string>

namespace springdrive {

/// A table's columns stay readable in the code that makes them.
template <typename... Values> void print(std::ostream &out, const char *format, Values... values) {
    const int length = std::snprintf(nullptr, 0, format, values...);
    std::string text(static_cast<std::size_t>(length) + 1, '\0');
    std::snprintf(text.data(), text.size(), format, values...);
    text.pop_back(); // the closing zero
    out << text;
}

} // namespace springdrive
