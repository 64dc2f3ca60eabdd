#include "base/one_line.h"

#include <array>
#include <charconv>

namespace springdrive {

namespace {

bool is_blank(char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte <= 0x20 || byte == 0x7f;
}

bool continues_a_character(char c) { return (static_cast<unsigned char>(c) & 0xc0U) == 0x80U; }

} // namespace

std::string one_line(std::string_view text, std::size_t max_length) {
    std::string line;
    for (const char c : text) {
        if (!is_blank(c)) {
            line += c;
        } else if (!line.empty() && line.back() != ' ') {
            line += ' ';
        }
        if (line.size() > max_length) {
            std::size_t end = max_length;
            while (end > 0 && continues_a_character(line[end])) {
                --end;
            }
            return line.substr(0, end) + "...";
        }
    }
    if (!line.empty() && line.back() == ' ') {
        line.pop_back();
    }
    return line;
}

std::string in_quotes(std::string_view text) {
    constexpr std::size_t kMaxName = 80;
    return "'" + one_line(text, kMaxName) + "'";
}

std::string shortest_text(double number) {
    std::array<char, 32> text{};
    const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), number);
    return {text.data(), end};
}

} // namespace springdrive
