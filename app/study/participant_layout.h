// Where everything of a ParticipantPicture is, and how large its text; without OpenGL.
//
// All lengths follow from the height of the picture, whatever the density of its pixels. Headings
// are 1/15 of the height and text 1/24 as long as that fits; where it does not, all text shrinks
// together, down to 1/24 and 1/36. Text that does not fit even then is too long: it is not
// `readable`, which a check of a protocol reports; it shrinks further rather than being clipped.
#pragma once

#include "app/study/participant_picture.h"
#include "app/view/text_lines.h"
#include "app/view/typeface.h"

#include <optional>
#include <vector>

namespace springdrive::app::study_screen {

/// In pixels, whole ones, from the top left.
struct PixelBox {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;

    [[nodiscard]] bool is_empty() const { return width <= 0 || height <= 0; }
    [[nodiscard]] bool contains(double at_x, double at_y) const {
        return at_x >= x && at_y >= y && at_x < x + width && at_y < y + height;
    }
    friend bool operator==(const PixelBox &, const PixelBox &) = default;
};

struct PlacedText {
    PixelBox box; ///< contains all of its letters
    TextLines lines;
};

struct PlacedChoice {
    PixelBox plate;
    PlacedText text; ///< within the plate
    PixelBox key;    ///< a key's cap within the plate; empty if there is none
    PlacedText key_text;
};

/// Boxes of what the picture does not have are empty.
struct ParticipantLayout {
    PlacedText heading;
    PlacedText text;
    PixelBox calm_plate; ///< behind heading and text
    PixelBox scene;
    std::vector<PlacedChoice> choices;
    PixelBox field;
    PlacedText typed; ///< within the field: its end, if it is too long for it
    PixelBox cursor;
    PixelBox left_bar; ///< all of it
    PlacedText left_text;
    PlacedText footer;
    PixelBox progress; ///< all of it
    bool is_readable = true;

    /// The choice whose plate is there.
    [[nodiscard]] std::optional<std::size_t> choice_at(double x, double y) const;
};

inline constexpr double kLeastHeadingPerHeight = 1.0 / 24.0;
inline constexpr double kLeastTextPerHeight = 1.0 / 36.0;

/// @pre width and height > 0
[[nodiscard]] ParticipantLayout lay_out(const ParticipantPicture &picture, int width, int height,
                                        const Typeface &typeface);

/// Whether text is large enough and all of it fits; for checks of protocols. Needs no window.
[[nodiscard]] bool is_readable(const ParticipantPicture &picture, const Typeface &typeface,
                               int width = 1280, int height = 720);

} // namespace springdrive::app::study_screen
