#include "app/view/text_lines.h"

#include "base/assertions.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace springdrive::app {

namespace {

constexpr double kLeading = 1.12; // of lines, per the font's own height of a line

bool is_blank(char32_t code_point) {
    return code_point == U' ' || code_point == U'\t' || code_point == U'\r';
}

/// A line may also end after one of these.
bool is_hyphen(char32_t code_point) { return code_point == U'-' || code_point == U'\u2010'; }

/// Places letters one after the other, from 0.
class Pen {
public:
    Pen(const Typeface &typeface, double size_px) : typeface_(typeface), size_px_(size_px) {}

    /// @return the place of the letter's origin [px]
    double add(char32_t code_point) {
        const int glyph = typeface_.glyph(is_blank(code_point) ? U' ' : code_point);
        if (last_ >= 0) {
            at_px_ += typeface_.kerning_px(last_, glyph, size_px_);
        }
        const double origin_px = at_px_;
        at_px_ += typeface_.advance_px(glyph, size_px_);
        last_ = glyph;
        return origin_px;
    }
    [[nodiscard]] int glyph() const { return last_; } ///< of the last letter
    [[nodiscard]] double at_px() const { return at_px_; }

private:
    const Typeface &typeface_;
    double size_px_;
    int last_ = -1;
    double at_px_ = 0.0;
};

/// A part of a paragraph as a line.
TextLine line_of(std::u32string_view letters, const Typeface &typeface, double size_px) {
    TextLine line;
    Pen pen(typeface, size_px);
    for (const char32_t letter : letters) {
        const double origin_px = pen.add(letter);
        if (!is_blank(letter)) {
            line.glyphs.push_back({pen.glyph(), static_cast<int>(std::lround(origin_px))});
        }
    }
    line.width_px = static_cast<int>(std::ceil(pen.at_px()));
    return line;
}

/// How many of the letters fit a line, at least one; and how many of those are shown.
struct Fit {
    std::size_t taken = 0;
    std::size_t shown = 0;
    bool breaks_word = false;
};

Fit fitted(std::u32string_view letters, const Typeface &typeface, double size_px,
           double most_width_px) {
    Pen pen(typeface, size_px);
    Fit at_break; // the last place where the line may end
    bool has_letters = false;
    for (std::size_t i = 0; i < letters.size(); ++i) {
        pen.add(letters[i]);
        const bool blank = is_blank(letters[i]);
        if (!blank && pen.at_px() > most_width_px) {
            return at_break.taken > 0
                       ? at_break
                       : Fit{std::max<std::size_t>(i, 1), std::max<std::size_t>(i, 1), true};
        }
        has_letters = has_letters || !blank;
        if (blank && has_letters) { // all blanks in a row are taken with the line before
            at_break = {i + 1, is_blank(letters[i - 1]) ? at_break.shown : i, false};
        } else if (is_hyphen(letters[i])) {
            at_break = {i + 1, i + 1, false};
        }
    }
    std::size_t shown = letters.size();
    while (shown > 0 && is_blank(letters[shown - 1])) {
        --shown;
    }
    return {letters.size(), shown, false};
}

void add_paragraph(TextLines &text, std::u32string_view letters, const Typeface &typeface,
                   int most_width_px) {
    do {
        const Fit fit = fitted(letters, typeface, text.size_px, most_width_px);
        text.lines.push_back(line_of(letters.substr(0, fit.shown), typeface, text.size_px));
        text.breaks_words = text.breaks_words || fit.breaks_word;
        letters.remove_prefix(fit.taken);
    } while (!letters.empty());
    text.lines.back().ends_paragraph = true;
}

} // namespace

int TextLines::height_px() const {
    const auto ends = std::ranges::count_if(lines, &TextLine::ends_paragraph);
    const int gaps = ends > 0 ? static_cast<int>(ends) - 1 : 0;
    return static_cast<int>(lines.size()) * line_height_px + gaps * paragraph_gap_px;
}

TextLines wrapped(std::string_view utf8, const Typeface &typeface, double size_px,
                  int most_width_px, TextAlign align) {
    SPRINGDRIVE_ASSERT(size_px > 0.0 && most_width_px > 0);
    TextLines text;
    text.size_px = size_px;
    text.line_height_px =
        static_cast<int>(std::lround(kLeading * typeface.line_height_px(size_px)));
    const double extra_px = text.line_height_px - typeface.line_height_px(size_px);
    text.ascent_px = static_cast<int>(std::lround(typeface.ascent_px(size_px) + 0.5 * extra_px));
    if (utf8.empty()) {
        return text;
    }
    const std::u32string letters = code_points(utf8);
    std::u32string_view rest = letters;
    for (;;) {
        const std::size_t end = rest.find(U'\n');
        add_paragraph(text, rest.substr(0, end), typeface, most_width_px);
        if (end == std::u32string_view::npos) {
            break;
        }
        rest.remove_prefix(end + 1);
    }
    for (const TextLine &line : text.lines) {
        text.width_px = std::max(text.width_px, line.width_px);
    }
    if (align == TextAlign::centre) {
        for (TextLine &line : text.lines) {
            line.x_px = (text.width_px - line.width_px) / 2;
        }
    }
    return text;
}

int text_width_px(std::string_view utf8, const Typeface &typeface, double size_px) {
    const std::u32string letters = code_points(utf8);
    return line_of(letters, typeface, size_px).width_px;
}

} // namespace springdrive::app
