#include "app/study/participant/participant_layout.h"

#include "base/input_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

namespace springdrive::app::study_screen {

namespace {

constexpr double kMax = 1.0 / 13.0; ///< of the height
constexpr double kMin = 1.0 / 36.0;
/// Letters are added by so many 32 code points at once, such as all of an alphabet.
constexpr int kWordsOfBlock = 4;

void use_block_of(ImFontGlyphRangesBuilder &used, int word) {
    const int first = word - word % kWordsOfBlock;
    std::fill_n(used.UsedChars.begin() + first, kWordsOfBlock, ~ImU32{0});
    used.UsedChars[0] = 0; // none before the blank
}

/// How much of a text, which is wider than a line, is on that line, and where the next one begins.
struct Break {
    std::size_t length = 0;
    std::size_t next = 0;
    bool is_within_word = false;
};

/// @param fitting  bytes that fit
Break broken(std::string_view text, std::size_t fitting) {
    constexpr auto kNone = std::string_view::npos;
    const std::size_t blank = text.find_last_of(" \t", fitting);
    const std::size_t last = blank == kNone ? kNone : text.find_last_not_of(" \t", blank);
    const auto end_of = [&](std::string_view hyphen) { // 0: there is none behind a letter
        const std::size_t at =
            fitting < hyphen.size() ? kNone : text.rfind(hyphen, fitting - hyphen.size());
        return at == kNone || at == 0 ? 0 : at + hyphen.size();
    };
    const std::size_t hyphen = std::max(end_of("-"), end_of("\u2010"));
    if (last != kNone && last + 1 >= hyphen) {
        return {last + 1, std::min(text.size(), text.find_first_not_of(" \t", blank)), false};
    }
    if (hyphen > 0) {
        return {hyphen, hyphen, false};
    }
    if (blank != kNone) { // those before the first word, which does not fit behind them
        return {0, std::min(text.size(), text.find_first_not_of(" \t", blank)), false};
    }
    std::size_t length = std::max<std::size_t>(fitting, 1);
    while (length < text.size() && (static_cast<unsigned char>(text[length]) & 0xC0U) == 0x80U) {
        ++length; // a whole letter
    }
    return {length, length, true};
}

[[noreturn]] void refuse_font() {
    throw InputError("no TrueType font at " SPRINGDRIVE_FONT
                     "; install fonts-dejavu-core, which has it");
}

} // namespace

Letters::Letters() {
    std::array<char, 4> start{};
    std::ifstream(SPRINGDRIVE_FONT, std::ios::binary).read(start.data(), start.size());
    if (start != std::array{'\0', '\1', '\0', '\0'}) {
        refuse_font();
    }
    atlas_.Flags = ImFontAtlasFlags_NoMouseCursors | ImFontAtlasFlags_NoBakedLines;
    used_.SetBit(IM_UNICODE_CODEPOINT_INVALID); // in place of letters that the font lacks
    for (const int latin : {0x20, 0xA0, 0x100, 0x2010, 0x2190}) { // with quotation marks and arrows
        use_block_of(used_, latin / 32);
    }
}

void Letters::prepare(int height, const std::vector<std::string_view> &texts) {
    ImFontGlyphRangesBuilder needed;
    for (const std::string_view text : texts) {
        needed.AddText(text.data(), text.data() + text.size());
    }
    bool is_new = height != height_;
    for (int word = 1; word < needed.UsedChars.Size; ++word) {
        if ((needed.UsedChars[word] & ~used_.UsedChars[word]) != 0) {
            use_block_of(used_, word);
            is_new = true;
        }
    }
    if (!is_new) {
        return;
    }
    height_ = height;
    ++version_;
    ImVector<ImWchar> ranges;
    used_.BuildRanges(&ranges);
    ImFontConfig config;
    config.OversampleH = config.OversampleV = 1;
    config.PixelSnapH = true;
    atlas_.Clear();
    for (int step = 0; step < kSizes; ++step) {
        atlas_.AddFontFromFileTTF(SPRINGDRIVE_FONT, size_px(step), &config, ranges.Data);
    }
    if (!atlas_.Build()) {
        height_ = 0; // the next time it is tried anew
        refuse_font();
    }
}

float Letters::size_px(int step) const {
    const double share = kMax * std::pow(kMin / kMax, step / (kSizes - 1.0));
    constexpr double kRoundOff = 1e-9;
    return static_cast<float>(std::ceil(share * height_ - kRoundOff));
}

/// Of letters that are drawn smaller than any of them, the least.
const ImFont &Letters::font(float size_px) const {
    int step = kSizes - 1;
    while (step > 0 && atlas_.Fonts[step]->FontSize < size_px) {
        --step;
    }
    return *atlas_.Fonts[step];
}

TextLines wrapped(std::string_view utf8, const ImFont &font, float size_px, float max_width,
                  float paragraph_gap) {
    TextLines text;
    text.font = &font;
    text.size_px = size_px;
    float top = 0.0F;
    const auto width_of = [&](std::string_view part, const char **fits) {
        return font
            .CalcTextSizeA(size_px, fits != nullptr ? max_width : 1e9F, 0.0F, part.data(),
                           part.data() + part.size(), fits)
            .x;
    };
    for (bool is_last = utf8.empty(); !is_last;) {
        const std::size_t feed = utf8.find('\n');
        is_last = feed == std::string_view::npos;
        std::string_view rest = utf8.substr(0, feed);
        utf8.remove_prefix(is_last ? utf8.size() : feed + 1);
        do {
            const char *fits = nullptr;
            static_cast<void>(width_of(rest, &fits));
            Break at{rest.size(), rest.size(), false};
            if (const auto fitting = static_cast<std::size_t>(fits - rest.data());
                fitting < rest.size()) {
                at = broken(rest, fitting);
            }
            const std::string_view line = rest.substr(0, at.length);
            rest.remove_prefix(at.next);
            if (line.empty() && !rest.empty()) {
                continue;
            }
            const float width = std::ceil(width_of(line, nullptr));
            text.lines.push_back({std::string(line), top, width});
            text.breaks_words = text.breaks_words || at.is_within_word;
            text.box.size.x = std::max(text.box.size.x, width);
            text.box.size.y = top + size_px;
            top += size_px;
        } while (!rest.empty());
        top += paragraph_gap;
    }
    return text;
}

} // namespace springdrive::app::study_screen
