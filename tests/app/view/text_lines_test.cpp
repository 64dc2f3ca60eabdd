// Covers app/view/typeface.cpp and app/view/text_lines.cpp.
#include "app/view/text_lines.h"
#include "base/input_error.h"

#include <gtest/gtest.h>
#include <stb/stb_truetype.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <random>

namespace springdrive::app {
namespace {

const Typeface &typeface() {
    static const Typeface kTypeface;
    return kTypeface;
}

/// Glyphs of all letters that are shown.
std::vector<int> glyphs_of(std::u32string_view letters) {
    std::vector<int> glyphs;
    for (const char32_t letter : letters) {
        if (letter != U' ' && letter != U'\n') {
            glyphs.push_back(typeface().glyph(letter));
        }
    }
    return glyphs;
}

TEST(CodePoints, ReplaceExactlyTheBytesThatAreNone) {
    EXPECT_EQ(code_points("aä€😀"), U"aä€😀");
    EXPECT_EQ(code_points("\x80z"), U"\uFFFDz");
    EXPECT_EQ(code_points("\xC0\xAF"), U"\uFFFD\uFFFD");                     // two forms of '/'
    EXPECT_EQ(code_points("\xED\xA0\x80"), U"\uFFFD\uFFFD\uFFFD");           // a surrogate
    EXPECT_EQ(code_points("\xF4\x90\x80\x80"), U"\uFFFD\uFFFD\uFFFD\uFFFD"); // beyond U+10FFFF
    EXPECT_EQ(code_points("\xE2\x82"), U"\uFFFD\uFFFD");                     // cut off
}

TEST(Typeface, HasTheLettersOfLatinGreekAndCyrillicAndNoOthersThanTheFont) {
    for (const char32_t letter : std::u32string_view(U"azÄÖÜäöüßéçñøåłşαβΩЖйя←→↵“”–")) {
        EXPECT_NE(typeface().glyph(letter), 0) << static_cast<unsigned>(letter);
    }
    EXPECT_EQ(typeface().glyph(U'漢'), 0);
}

TEST(Typeface, RefusesWhatIsNoFont) {
    EXPECT_THROW(Typeface("/nowhere/font.ttf"), InputError);
    EXPECT_THROW(Typeface("/proc/self/cmdline"), InputError);
}

TEST(TextWidth, IsTheSumOfAdvancesAndKerningOfTheFont) {
    std::ifstream in(SPRINGDRIVE_FONT, std::ios::binary);
    const std::vector<unsigned char> bytes{std::istreambuf_iterator<char>(in), {}};
    stbtt_fontinfo font{};
    ASSERT_NE(stbtt_InitFont(&font, bytes.data(), 0), 0);
    for (const std::string text : {"AVATAR To Yes", "Wie fühlt es sich an?", "Тест", "x"}) {
        for (const double size_px : {17.0, 20.0, 33.0, 96.0}) {
            const std::u32string letters = code_points(text);
            int units = 0;
            for (std::size_t i = 0; i < letters.size(); ++i) {
                int advance = 0;
                int bearing = 0;
                stbtt_GetCodepointHMetrics(&font, static_cast<int>(letters[i]), &advance, &bearing);
                units += advance;
                if (i > 0) {
                    units += stbtt_GetCodepointKernAdvance(&font, static_cast<int>(letters[i - 1]),
                                                           static_cast<int>(letters[i]));
                }
            }
            const auto scale =
                static_cast<double>(stbtt_ScaleForPixelHeight(&font, static_cast<float>(size_px)));
            // Rounded up to a whole pixel; sums of some twenty floats are right to 1e-3.
            const int width = text_width_px(text, typeface(), size_px);
            EXPECT_GE(width, units * scale - 1e-3) << text;
            EXPECT_LT(width, units * scale + 1.0 + 1e-3) << text;
        }
    }
}

TEST(WrappedText, LosesNoLetterAndKeepsToItsWidth) {
    std::mt19937_64 random(7);
    const std::u32string alphabet = U"aaeinorstlÄüßΩЖ-,.    ";
    for (int trial = 0; trial < 300; ++trial) {
        std::string text;
        std::u32string letters;
        const std::size_t length = 1 + random() % 120;
        for (std::size_t i = 0; i < length; ++i) {
            const char32_t letter =
                random() % 40 == 0 ? U'\n' : alphabet[random() % alphabet.size()];
            letters += letter;
            if (letter < 0x80) {
                text += static_cast<char>(letter);
            } else {
                text += static_cast<char>(0xC0U | letter >> 6U);
                text += static_cast<char>(0x80U | (letter & 0x3FU));
            }
        }
        ASSERT_EQ(code_points(text), letters);
        const int most_px = 40 + static_cast<int>(random() % 400);
        const TextLines lines = wrapped(text, typeface(), 20.0, most_px,
                                        trial % 2 == 0 ? TextAlign::left : TextAlign::centre);
        std::vector<int> shown;
        for (const TextLine &line : lines.lines) {
            ASSERT_LE(line.width_px, most_px);
            ASSERT_LE(line.x_px + line.width_px, lines.width_px);
            for (const PlacedGlyph &glyph : line.glyphs) {
                shown.push_back(glyph.glyph);
            }
        }
        ASSERT_EQ(shown, glyphs_of(letters)) << text;
        ASSERT_EQ(lines.height_px(), static_cast<int>(lines.lines.size()) * lines.line_height_px);
        const auto paragraphs = std::ranges::count_if(lines.lines, &TextLine::ends_paragraph);
        ASSERT_EQ(paragraphs, 1 + std::ranges::count(letters, U'\n'));
    }
}

TEST(WrappedText, BreaksAtBlanksAndAWordOnlyWhereItIsLongerThanALine) {
    const int two_words = text_width_px("one two", typeface(), 20.0);
    const TextLines apart = wrapped("one two", typeface(), 20.0, two_words - 1);
    EXPECT_EQ(apart.lines.size(), 2U);
    EXPECT_FALSE(apart.breaks_words);
    EXPECT_EQ(wrapped("one two", typeface(), 20.0, two_words).lines.size(), 1U);
    const int half_word = text_width_px("Rindfleisch", typeface(), 20.0);
    EXPECT_TRUE(wrapped("Rindfleischetikett", typeface(), 20.0, half_word).breaks_words);
}

} // namespace
} // namespace springdrive::app
