// For tests of what is written for other programs: names of all characters that can be printed, and
// what a reader of SVG makes of its texts.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <random>
#include <regex>
#include <string>
#include <string_view>
#include <utility>

namespace springdrive::testing {

/// Of 1 to 24 characters, most of them such as some language gives a meaning.
inline std::string random_name(std::mt19937_64 &random) {
    constexpr std::array<std::string_view, 40> kOthers{
        "ä",      "ß",          "Ł",  "ą",  "Ж",  "ё",  "ω",  "λ",      "ή",      "я",
        "א",      "ש",          "ع",  "ي",  "あ", "手", "触", "한",     "क्",      "ไ",
        "°",      "µ",          "Ω",  "−",  "–",  "…",  "“",  "’",      "«",      "±",
        "\u0301", "\U0001F590", "＝", "％", "；", "，", "＠", "\u00A0", "\u2003", "\u200D"};
    std::string name;
    for (std::size_t left = 1 + random() % 24; left > 0; --left) {
        const std::size_t kind = random() % 8;
        if (kind == 0) {
            name += kOthers[random() % kOthers.size()];
        } else if (kind < 4) {
            constexpr std::string_view kSpecial = " !\"#$%&'()*+,-./:;<=>?@[\\]^_`{|}~";
            name += kSpecial[random() % kSpecial.size()];
        } else {
            name += static_cast<char>(' ' + random() % ('~' - ' ' + 1));
        }
    }
    return '(' + name + ')'; // whatever it ends with can be seen
}

/// All that stands between the tags <text> of an SVG, in a row.
inline std::string texts_of_svg(const std::string &svg) {
    static const std::regex kText("<text[^>]*>([^]*?)</text>");
    static const std::regex kTag("<[^>]*>");
    std::string all;
    for (std::sregex_iterator one(svg.begin(), svg.end(), kText), end; one != end; ++one) {
        all += std::regex_replace(one->str(1), kTag, "");
    }
    for (const auto &[written, meant] :
         {std::pair("&lt;", "<"), {"&gt;", ">"}, {"&quot;", "\""}, {"&amp;", "&"}}) {
        for (std::size_t at = 0; (at = all.find(written, at)) != std::string::npos; ++at) {
            all.replace(at, std::string_view(written).size(), meant);
        }
    }
    return all;
}

/// Where lines may have been broken.
inline std::string without_blanks(std::string text) {
    std::erase_if(text, [](char c) { return c == ' ' || c == '\n' || c == '\t'; });
    return text;
}

/// Whether a text of an SVG is this, apart from blanks.
inline bool is_in_svg(const std::string &svg, const std::string &text) {
    return without_blanks(texts_of_svg(svg)).find(without_blanks(text)) != std::string::npos;
}

} // namespace springdrive::testing
