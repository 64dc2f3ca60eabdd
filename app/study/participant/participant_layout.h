// Where everything of a ParticipantPicture is, and how large its text; without OpenGL.
//
// All lengths follow from the height of the picture, whatever the density of its pixels. Headings
// are 1/13 of the height and text 1/22 as long as that fits; where it does not, all text shrinks
// together, down to 1/24 and 1/36. Text that does not fit even then is too long: it is not
// readable, which a check of a protocol reports, and shrinks further rather than being clipped.
//
// Without a scene everything is one column in the middle. A scene is always at the same place,
// whatever is above and below it, so that nothing moves within a trial.
#pragma once

#include "app/study/participant/choice_plates.h"
#include "app/study/participant/curve_chart.h"
#include "app/study/participant/participant_picture.h"
#include "app/study/participant/pixel_box.h"

#include <optional>
#include <vector>

namespace springdrive::app::study_screen {

/// Boxes of what the picture does not have are empty.
struct ParticipantLayout {
    PixelBox calm_plate; ///< behind heading and text
    PlacedText heading;
    PlacedText text;
    PixelBox scene;
    CurveChart curve;
    PixelBox left_bar; ///< all of it, however much is left
    PlacedText left_text;
    PixelBox field;
    PlacedText typed; ///< within the field: its last lines, if there are more than it holds
    PixelBox cursor;  ///< within the field
    std::vector<PlacedChoice> choices;
    PlacedText footer;
    PixelBox progress; ///< all of it
    bool is_readable = true;

    /// The choice whose plate is there.
    [[nodiscard]] std::optional<std::size_t> choice_at(double x, double y) const;
};

inline constexpr double kLeastHeadingPerHeight = 1.0 / 24.0;
inline constexpr double kLeastTextPerHeight = 1.0 / 36.0;

/// Depends neither on how much is done or left, nor on the ball or what is chosen.
/// @pre width and height > 0
[[nodiscard]] ParticipantLayout lay_out(const ParticipantPicture &picture, int width, int height,
                                        const Typeface &typeface);

/// Whether all text fits in a size that can be read from where a participant sits; for checks of
/// protocols. Needs no window.
[[nodiscard]] bool is_readable(const ParticipantPicture &picture, const Typeface &typeface,
                               int width = 1280, int height = 720);

} // namespace springdrive::app::study_screen
