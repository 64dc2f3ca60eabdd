// How the plates of choices are arranged; without OpenGL.
#pragma once

#include "app/study/participant/participant_picture.h"
#include "app/study/participant/pixel_box.h"
#include "app/view/text_lines.h"

#include <optional>
#include <span>
#include <vector>

namespace springdrive::app::study_screen {

struct PlacedText {
    PixelBox box; ///< of its lines
    TextLines lines;
};

struct PlacedChoice {
    PixelBox plate;
    PlacedText text; ///< within the plate
    PixelBox key;    ///< a key's cap within the plate; empty if there is none
    PlacedText key_text;
};

/// All plates are of one size, in rows that are filled one after the other.
struct ChoicePlates {
    std::vector<PlacedChoice> choices; ///< from 0, 0
    int width = 0;
    int height = 0;
};

/// In as few rows as the texts allow, with the key beside its text or above it. Nothing if a text
/// would be broken within a word, or into more than two lines beside its key, or three below it.
[[nodiscard]] std::optional<ChoicePlates> arranged(std::span<const AnswerChoice> choices,
                                                   const Typeface &typeface, double text_px,
                                                   int most_width, int most_plate_width);

/// The arrangement of the least height, whatever becomes of the texts.
[[nodiscard]] ChoicePlates squeezed(std::span<const AnswerChoice> choices, const Typeface &typeface,
                                    double text_px, int most_width, int most_plate_width);

/// With everything shifted.
[[nodiscard]] PlacedText moved(PlacedText text, int right, int down);
[[nodiscard]] PlacedChoice moved(PlacedChoice choice, int right, int down);

} // namespace springdrive::app::study_screen
