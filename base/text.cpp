#include "base/text.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

namespace springdrive {

namespace {

bool is_blank(char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte <= 0x20 || byte == 0x7f;
}

bool continues_a_character(char c) { return (static_cast<unsigned char>(c) & 0xc0U) == 0x80U; }

/// At most so many bytes, and no part of a character.
std::string cut(std::string text, std::size_t max_length) {
    if (text.size() <= max_length) {
        return text;
    }
    while (max_length > 0 && continues_a_character(text[max_length])) {
        --max_length;
    }
    return text.substr(0, max_length) + "...";
}

/// Of the character that a text begins with, as Unicode defines UTF-8 (its table 3-7); 0 if none.
/// @pre not empty
std::size_t bytes_of_character(std::string_view text) {
    constexpr std::array<unsigned, 5> kFirstOfLength{0, 0, 0x80, 0x800, 0x10000};
    const auto lead = static_cast<unsigned char>(text.front());
    const std::size_t length = lead < 0x80 ? 1 : lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : 4;
    if ((lead >= 0x80 && lead < 0xc2) || lead > 0xf4 || length > text.size()) {
        return 0;
    }
    unsigned character = length == 1 ? lead : lead & (0x7fU >> length);
    for (std::size_t k = 1; k < length; ++k) {
        if (!continues_a_character(text[k])) {
            return 0;
        }
        character = character << 6U | (static_cast<unsigned char>(text[k]) & 0x3fU);
    }
    const bool is_half_of_pair = character >= 0xd800 && character <= 0xdfff;
    return character < kFirstOfLength.at(length) || is_half_of_pair || character > 0x10ffff
               ? 0
               : length;
}

/// With a blank for each control character.
std::string with_blanks(std::string_view text) {
    std::string line(text);
    std::ranges::replace_if(line, is_blank, ' ');
    return line;
}

/// With U+FFFD for U+FFFE and U+FFFF, which no XML document can have.
std::string with_letters_of_xml(std::string text) {
    for (std::size_t at = 0; (at = text.find("\xef\xbf", at)) != std::string::npos; at += 2) {
        if (text.substr(at + 2, 1) >= "\xbe") {
            text[at + 2] = '\xbd';
        }
    }
    return text;
}

/// A character of which nothing is seen: blanks and what controls.
bool is_unseen(std::string_view character) {
    const auto byte = [character](std::size_t i) {
        return static_cast<unsigned char>(i < character.size() ? character[i] : '\0');
    };
    switch (character.size()) {
    case 1:
        return is_blank(character[0]);
    case 2: // U+0080 to U+00A0, U+00AD
        return byte(0) == 0xc2 && (byte(1) <= 0xa0 || byte(1) == 0xad);
    case 3: // U+2000 to U+200F, U+2028 to U+202F, U+205F to U+206F, and three by themselves
        return (byte(0) == 0xe2 && byte(1) == 0x80 &&
                (byte(2) <= 0x8f || (byte(2) >= 0xa8 && byte(2) <= 0xaf))) ||
               (byte(0) == 0xe2 && byte(1) == 0x81 && byte(2) >= 0x9f && byte(2) <= 0xaf) ||
               character == "\u1680" || character == "\u3000" || character == "\ufeff";
    default:
        return false;
    }
}

bool is_control(std::string_view character) {
    return character != " " && character != "\u00a0" && character != "\u00ad" &&
           (character.size() < 3 || character == "\u2028" || character == "\u2029") &&
           is_unseen(character);
}

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
            return cut(std::move(line), max_length);
        }
    }
    if (!line.empty() && line.back() == ' ') {
        line.pop_back();
    }
    return line;
}

std::string in_quotes(std::string_view text) {
    constexpr std::size_t kMaxName = 80;
    return "'" + cut(with_blanks(text), kMaxName) + "'";
}

std::string validate_name(std::string_view name) {
    std::size_t begin = 0;
    for (std::size_t i = 1; i <= name.size(); ++i) {
        if (i < name.size() && continues_a_character(name[i])) {
            continue;
        }
        const std::string_view character = name.substr(begin, i - begin);
        if (is_control(character)) {
            return "has a line end, tab or other control character; take it out";
        }
        if (is_unseen(character) && (begin == 0 || i == name.size())) {
            return fmt::format("{} with a blank, which nobody sees; take it off",
                               begin == 0 ? "begins" : "ends");
        }
        begin = i;
    }
    return {};
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
    const std::string line = with_blanks(text);
    const std::size_t first = line.find_first_not_of(' ');
    if (first == std::string::npos) {
        return "n/a";
    }
    const std::string cell = guard_formula(
        cut(line.substr(first, line.find_last_not_of(' ') + 1 - first), kMaxCellBytes));
    return cell.find('"') == std::string::npos ? cell : enclosed(cell, '"');
}

std::string gnuplot_string(std::string_view text) {
    return enclosed(with_letters_of_xml(with_blanks(text)), '\'');
}

bool is_utf8(std::string_view text) {
    std::size_t at = 0;
    while (at < text.size()) {
        const std::size_t bytes = bytes_of_character(text.substr(at));
        if (bytes == 0) {
            return false;
        }
        at += bytes;
    }
    return true;
}

std::string as_utf8(std::string_view text) {
    std::string shown;
    while (!text.empty()) {
        const std::size_t bytes = bytes_of_character(text);
        const bool is_shown = bytes > 1 || (bytes == 1 && (text[0] == ' ' || !is_blank(text[0])));
        shown += is_shown ? std::string(text.substr(0, bytes))
                          : fmt::format("\\x{:02x}", static_cast<unsigned char>(text.front()));
        text.remove_prefix(std::max(bytes, std::size_t{1}));
    }
    return shown;
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
    for (const char c : with_letters_of_xml(std::string(text))) {
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
