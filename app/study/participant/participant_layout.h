// Where everything of a ParticipantPicture is, and how large its text; without OpenGL.
//
// All lengths follow from the height of the picture, whatever the density of its pixels. Headings
// are 1/13 of the height and text 1/22 as long as that fits; where it does not, all text shrinks
// together, text down to 1/36. Text that does not fit even then is too long: it is not readable,
// which a check of a protocol reports, and shrinks further rather than being clipped.
//
// Without a scene everything is one column in the middle. A scene is always at the same place,
// whatever is above and below it, so that nothing moves within a trial.
#pragma once

#include "app/study/participant/letters.h"
#include "app/study/participant/participant_picture.h"

#include <array>
#include <optional>
#include <vector>

namespace springdrive::app::study_screen {

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
