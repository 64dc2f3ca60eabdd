// The letters of the participant's screen, and text as lines that fit a width. Without OpenGL.
//
// Each letter of a size that can be read lies on whole pixels in the size in which it was
// rasterised, so that it looks the same whatever was drawn before. ImGui knows letters up to
// U+FFFF, and does not kern.
#pragma once

#include "app/widgets/rectangle.h"

#include <imgui.h>

#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app::study_screen {

struct TextLine {
    std::string text;
    float top = 0.0F; ///< below that of the first line [px]
    float width = 0.0F;
};

struct TextLines {
    Rectangle box; ///< of all lines; at 0, 0 until they are placed
    std::vector<TextLine> lines;
    const ImFont *font = nullptr; ///< of the letters; valid until others are added to them
    float size_px = 0.0F;
    bool is_centred = true;
    bool breaks_words = false;
};

/// Fonts of some sizes for pictures of one height at a time.
class Letters {
public:
    /// From the largest heading, 1/13 of the height, down to the least readable text, 1/36 of it.
    static constexpr int kSizes = 7;

    /// @throw InputError if the font that the program was built with is missing, with the remedy
    Letters();
    ~Letters() = default;
    Letters(const Letters &) = delete;
    Letters &operator=(const Letters &) = delete;

    /// Makes the fonts anew for another height, and for a text with letters of a kind that they do
    /// not have so far. Those of Latin alphabets they always have.
    /// @throw InputError if the font cannot be read, as above
    void prepare(int height, const std::vector<std::string_view> &texts);

    /// How often fonts were made.
    [[nodiscard]] int version() const { return version_; }
    /// Of the fonts, from 0, the largest.
    [[nodiscard]] float size_px(int step) const;
    /// Pixels from the highest ascender to the lowest descender.
    [[nodiscard]] const ImFont &font(float size_px) const;
    [[nodiscard]] ImFontAtlas &atlas() { return atlas_; }

private:
    ImFontAtlas atlas_;
    ImFontGlyphRangesBuilder used_;
    int height_ = 0;
    int version_ = 0;
};

/// Wraps at blanks and after hyphens; where a single word is wider than the line, within it. A line
/// feed begins a new paragraph, an empty one is kept. Blanks at which a line is broken are dropped.
/// @param paragraph_gap  between paragraphs [px]
[[nodiscard]] TextLines wrapped(std::string_view utf8, const ImFont &font, float size_px,
                                float max_width, float paragraph_gap = 0.0F);

} // namespace springdrive::app::study_screen
