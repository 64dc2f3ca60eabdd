// Text as lines that fit a width; without OpenGL.
#pragma once

#include "app/view/typeface.h"

#include <cstdint>
#include <string_view>
#include <vector>

namespace springdrive::app {

struct PlacedGlyph {
    int glyph = 0;
    int x_px = 0; ///< of its origin, from the left of the line
    friend bool operator==(const PlacedGlyph &, const PlacedGlyph &) = default;
};

struct TextLine {
    std::vector<PlacedGlyph> glyphs; ///< without those of blanks
    int x_px = 0;                    ///< of its left, from the left of all lines
    int width_px = 0;
    bool ends_paragraph = false;
};

enum class TextAlign : std::uint8_t { left, centre };

struct TextLines {
    std::vector<TextLine> lines;
    double size_px = 0.0;
    int line_height_px = 0;
    int ascent_px = 0; ///< from the top of a line to its base
    int width_px = 0;  ///< of the widest line
    bool breaks_words = false;
    int paragraph_gap_px = 0; ///< between the last line of a paragraph and the next one

    [[nodiscard]] int height_px() const;
};

/// Wraps at blanks; where a single word is wider than the line, within it. A line feed begins a new
/// line, an empty one is kept. Blanks at which a line is broken are dropped; all other letters are
/// in the lines, in their order. Glyphs begin at whole pixels.
/// @pre most_width_px > 0, size_px > 0. A glyph that is wider than that by itself has its own line.
[[nodiscard]] TextLines wrapped(std::string_view utf8, const Typeface &typeface, double size_px,
                                int most_width_px, TextAlign align = TextAlign::left);

/// Width of a text in one line.
[[nodiscard]] int text_width_px(std::string_view utf8, const Typeface &typeface, double size_px);

} // namespace springdrive::app
