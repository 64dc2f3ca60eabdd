#include "app/view/typeface.h"

#include "base/input_error.h"

#include <stb_truetype.h>

#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

namespace springdrive::app {

namespace {

constexpr char32_t kReplacement = U'\uFFFD';

bool continues(unsigned char byte) { return (byte & 0xC0U) == 0x80U; }

/// Length of the sequence that a byte begins, by Table 3-7 of the Unicode standard; 0 of no such
/// byte.
std::size_t sequence_length(unsigned char first) {
    if (first < 0x80U) {
        return 1;
    }
    if (first >= 0xC2U && first <= 0xDFU) {
        return 2;
    }
    if (first >= 0xE0U && first <= 0xEFU) {
        return 3;
    }
    return first >= 0xF0U && first <= 0xF4U ? 4 : 0;
}

/// The second byte is restricted so that no code point has two forms and none is a surrogate.
bool allows_second(unsigned char first, unsigned char second) {
    switch (first) {
    case 0xE0U:
        return second >= 0xA0U;
    case 0xEDU:
        return second <= 0x9FU;
    case 0xF0U:
        return second >= 0x90U;
    case 0xF4U:
        return second <= 0x8FU;
    default:
        return true;
    }
}

std::vector<unsigned char> bytes_of(const std::filesystem::path &file, const std::string &remedy) {
    std::ifstream in(file, std::ios::binary);
    std::vector<unsigned char> bytes{std::istreambuf_iterator<char>(in), {}};
    if (!in || bytes.empty()) {
        throw InputError("no font at " + file.string() + remedy);
    }
    return bytes;
}

constexpr const char *kRemedy = "; install fonts-dejavu-core, which has it";

} // namespace

std::u32string code_points(std::string_view utf8) {
    std::u32string result;
    result.reserve(utf8.size());
    for (std::size_t i = 0; i < utf8.size();) {
        const auto first = static_cast<unsigned char>(utf8[i]);
        const std::size_t length = sequence_length(first);
        bool is_whole = length > 0 && i + length <= utf8.size();
        char32_t code = length == 1 ? first : first & (0xFFU >> (length + 1));
        for (std::size_t k = 1; is_whole && k < length; ++k) {
            const auto byte = static_cast<unsigned char>(utf8[i + k]);
            is_whole = continues(byte) && (k > 1 || allows_second(first, byte));
            code = (code << 6U) | (byte & 0x3FU);
        }
        result += is_whole ? code : kReplacement;
        i += is_whole ? length : 1;
    }
    return result;
}

struct Typeface::Font {
    std::vector<unsigned char> bytes;
    stbtt_fontinfo info{};
    int ascent = 0; ///< in the font's units, as the others
    int descent = 0;
    int line_gap = 0;

    [[nodiscard]] float scale(double size_px) const {
        return stbtt_ScaleForPixelHeight(&info, static_cast<float>(size_px));
    }
};

Typeface::Typeface() : Typeface(SPRINGDRIVE_FONT) {}

Typeface::Typeface(const std::filesystem::path &file) : font_(std::make_unique<Font>()) {
    font_->bytes = bytes_of(file, kRemedy);
    const int offset = stbtt_GetFontOffsetForIndex(font_->bytes.data(), 0);
    if (offset < 0 || stbtt_InitFont(&font_->info, font_->bytes.data(), offset) == 0) {
        throw InputError(file.string() + " is no TrueType font" + kRemedy);
    }
    stbtt_GetFontVMetrics(&font_->info, &font_->ascent, &font_->descent, &font_->line_gap);
}

Typeface::~Typeface() = default;
Typeface::Typeface(Typeface &&) noexcept = default;
Typeface &Typeface::operator=(Typeface &&) noexcept = default;

int Typeface::glyph(char32_t code_point) const {
    return stbtt_FindGlyphIndex(&font_->info, static_cast<int>(code_point));
}

double Typeface::ascent_px(double size_px) const {
    return static_cast<double>(font_->scale(size_px)) * font_->ascent;
}

double Typeface::line_height_px(double size_px) const {
    return static_cast<double>(font_->scale(size_px)) *
           (font_->ascent - font_->descent + font_->line_gap);
}

double Typeface::advance_px(int glyph, double size_px) const {
    int advance = 0;
    int bearing = 0;
    stbtt_GetGlyphHMetrics(&font_->info, glyph, &advance, &bearing);
    return static_cast<double>(font_->scale(size_px)) * advance;
}

double Typeface::kerning_px(int glyph, int next, double size_px) const {
    return static_cast<double>(font_->scale(size_px)) *
           stbtt_GetGlyphKernAdvance(&font_->info, glyph, next);
}

Typeface::Picture Typeface::picture(int glyph, double size_px) const {
    const float scale = font_->scale(size_px);
    int left = 0;
    int top = 0;
    int right = 0;
    int bottom = 0;
    stbtt_GetGlyphBitmapBox(&font_->info, glyph, scale, scale, &left, &top, &right, &bottom);
    Picture picture{right - left, bottom - top, left, top, {}};
    if (picture.width > 0 && picture.height > 0) {
        picture.coverage.resize(static_cast<std::size_t>(picture.width) *
                                static_cast<std::size_t>(picture.height));
        stbtt_MakeGlyphBitmap(&font_->info, picture.coverage.data(), picture.width, picture.height,
                              picture.width, scale, scale, glyph);
    }
    return picture;
}

} // namespace springdrive::app
