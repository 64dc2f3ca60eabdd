// Where everything of a ParticipantPicture is, and how large its text; without OpenGL.
//
// All lengths follow from the height of the picture, whatever the density of its pixels. Headings
// are 1/13 of the height and text 1/22 as long as that fits; where it does not, all text shrinks
// together, text down to 1/36. Text that does not fit even then is too long: it is not readable,
// which a check of a protocol reports, and shrinks further rather than being clipped.
//
// Without a scene everything is one column in the middle. A scene is always at the same place,
// whatever is above and below it, so that nothing moves within a trial.
//
// Each letter of a size that can be read lies on whole pixels in the size in which it was
// rasterised, so that it looks the same whatever was drawn before. ImGui knows letters up to
// U+FFFF, and does not kern.
#pragma once

#include "app/study/participant/participant_picture.h"
#include "app/widgets/rectangle.h"

#include <imgui.h>

#include <array>
#include <optional>
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

/// An OwnCurve in a box of the screen.
struct CurveChart {
    Rectangle plot; ///< within the axes
    std::vector<TextLines> labels;
    float line_px = 1.0F; ///< thickness of lines

    [[nodiscard]] float x_px(const OwnCurve &curve, double level) const;
    [[nodiscard]] float y_px(double right_share) const;
};

/// Shares that are named at its axis.
inline constexpr std::array<double, 5> kNamedShares{0.0, 0.25, 0.5, 0.75, 1.0};

/// Radius of a dot: its area is proportional to the trials, and one of `kFullTrials` has the
/// largest radius; more are not drawn larger. @param height_px  of the plot
[[nodiscard]] float dot_radius_px(int trials, float height_px);
inline constexpr int kFullTrials = 16;

/// Everything is within the box. @param text_px  of all labels
/// @pre the box is not empty, 0 < lowest_level < highest_level
[[nodiscard]] CurveChart arranged(const OwnCurve &curve, const Rectangle &box, const ImFont &font,
                                  float text_px);

struct PlacedChoice {
    Rectangle card;
    Rectangle key; ///< a key's cap within the plate; empty if there is none
    TextLines text;
    TextLines key_text;
};

/// In whole pixels from the top left. Boxes of what the picture does not have are empty.
struct ParticipantLayout {
    Rectangle calm_plate; ///< behind heading and text
    TextLines heading;
    TextLines text;
    Rectangle scene;
    CurveChart curve;
    Rectangle left_bar; ///< all of it, however much is left
    TextLines left_text;
    Rectangle field;
    TextLines typed;  ///< within the field: its last lines, if there are more than it holds
    Rectangle cursor; ///< within the field
    std::vector<PlacedChoice> choices;
    TextLines footer;
    Rectangle progress; ///< all of it
    bool is_readable = true;

    /// The choice whose plate is there.
    [[nodiscard]] std::optional<std::size_t> choice_at(double x, double y) const;
};

/// Depends neither on how much is done or left, nor on the ball.
/// @param letters  with which it is drawn; made ready for it. @pre width and height > 0
[[nodiscard]] ParticipantLayout lay_out(const ParticipantPicture &picture, int width, int height,
                                        Letters &letters);

/// Whether all text fits in a size that can be read from where a participant sits; for checks of
/// protocols. Needs no window.
[[nodiscard]] bool is_readable(const ParticipantPicture &picture, Letters &letters,
                               int width = 1280, int height = 720);

[[nodiscard]] inline bool is_empty(const Rectangle &box) {
    return box.size.x <= 0.0F || box.size.y <= 0.0F;
}

} // namespace springdrive::app::study_screen
