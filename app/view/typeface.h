// A TrueType font: widths of text and pictures of letters; without OpenGL.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

namespace springdrive::app {

/// The code points of UTF-8; U+FFFD for each byte that is none.
[[nodiscard]] std::u32string code_points(std::string_view utf8);

class Typeface {
public:
    /// The font that the program was built with. @throw InputError with the remedy if it is
    /// missing.
    Typeface();
    /// @throw InputError naming the file if it cannot be read or is no TrueType font.
    explicit Typeface(const std::filesystem::path &file);
    ~Typeface();
    Typeface(Typeface &&) noexcept;
    Typeface &operator=(Typeface &&) noexcept;
    Typeface(const Typeface &) = delete;
    Typeface &operator=(const Typeface &) = delete;

    /// Number of the letter's picture in the font; 0, which is a box, of one that it lacks.
    [[nodiscard]] int glyph(char32_t code_point) const;

    // Sizes are the pixels from the highest ascender to the lowest descender, as in ImGui.
    [[nodiscard]] double ascent_px(double size_px) const; ///< from the top of a line to its base
    /// From one line's base to the next one's.
    [[nodiscard]] double line_height_px(double size_px) const;
    /// From a glyph's origin to that of the next one, without kerning.
    [[nodiscard]] double advance_px(int glyph, double size_px) const;
    /// To be added between two glyphs.
    [[nodiscard]] double kerning_px(int glyph, int next, double size_px) const;

    /// How much of each pixel a glyph covers, 0 to 255, top row first.
    struct Picture {
        int width = 0;
        int height = 0;
        int left = 0; ///< of its top left corner, from the glyph's origin
        int top = 0;  ///< the same, down from the base line: negative above it
        std::vector<std::uint8_t> coverage;
    };
    [[nodiscard]] Picture picture(int glyph, double size_px) const;

private:
    struct Font;
    std::unique_ptr<Font> font_;
};

} // namespace springdrive::app
