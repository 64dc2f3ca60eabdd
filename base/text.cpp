#include "base/text.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace springdrive {

namespace {

bool is_blank(char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte <= 0x20 || byte == 0x7f;
}

bool continues_a_character(char c) { return (static_cast<unsigned char>(c) & 0xc0U) == 0x80U; }

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

/// Between two quotes, with those inside doubled.
std::string enclosed(std::string_view text, char quote) {
    std::string inside(1, quote);
    for (const char c : text) {
        inside.append(c == quote ? 2 : 1, c);
    }
    return inside + quote;
}

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

std::string guard_formula(std::string_view text) {
    const bool needs_it = begins_formula(after_quotes(text)) && !is_number(text);
    return (needs_it ? "'" : "") + std::string(text);
}

std::string csv_cell(std::string_view text) {
    const std::string guarded = guard_formula(text);
    return guarded.find_first_of(",\"\n\r") == std::string::npos ? guarded : enclosed(guarded, '"');
}

std::string csv_cell(double number) {
    return std::isfinite(number) ? fmt::format("{}", number) : "";
}

std::string tsv_cell(std::string_view text) {
    constexpr std::size_t kMaxCellBytes = 100'000;
    const std::string line = guard_formula(one_line(std::string(text), kMaxCellBytes));
    return line.empty() ? "n/a" : line.find('"') == std::string::npos ? line : enclosed(line, '"');
}

std::string gnuplot_string(std::string_view text) {
    std::string line(text);
    std::ranges::replace(line, '\n', ' ');
    return enclosed(line, '\'');
}

bool is_utf8(std::string_view text) {
    constexpr std::array<unsigned, 5> kFirstOfLength{0, 0, 0x80, 0x800, 0x10000};
    for (std::size_t i = 0; i < text.size();) {
        const auto lead = static_cast<unsigned char>(text[i]);
        const std::size_t length = lead < 0x80 ? 1 : lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : 4;
        if ((lead >= 0x80 && lead < 0xc2) || lead > 0xf4 || i + length > text.size()) {
            return false;
        }
        unsigned character = length == 1 ? lead : lead & (0x7fU >> length);
        for (std::size_t k = 1; k < length; ++k) {
            const auto next = static_cast<unsigned char>(text[i + k]);
            if ((next & 0xc0U) != 0x80U) {
                return false;
            }
            character = character << 6U | (next & 0x3fU);
        }
        const bool is_half_of_pair = character >= 0xd800 && character <= 0xdfff;
        if (character < kFirstOfLength.at(length) || is_half_of_pair || character > 0x10ffff) {
            return false;
        }
        i += length;
    }
    return true;
}

std::string toml_string(std::string_view text) {
    std::string inside;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < ' ' || byte == 0x7f) {
            inside += fmt::format("\\u{:04x}", byte);
        } else {
            inside += c == '"' || c == '\\' ? std::string{'\\', c} : std::string(1, c);
        }
    }
    return '"' + inside + '"';
}

std::string toml_number(double number) {
    const std::string digits = shortest_text(number);
    return digits.find_first_of(".e") == std::string::npos ? digits + ".0" : digits;
}

std::string xml_text(std::string_view text) {
    std::string escaped;
    for (const char c : text) {
        switch (c) {
        case '&':
            escaped += "&amp;";
            break;
        case '<':
            escaped += "&lt;";
            break;
        case '>':
            escaped += "&gt;";
            break;
        default:
            if (static_cast<unsigned char>(c) >= ' ' || c == '\t' || c == '\n' || c == '\r') {
                escaped += c;
            }
        }
    }
    return escaped;
}

} // namespace springdrive
