// What every layout of a participant's screen must hold.
#pragma once

#include "app/study/participant/participant_layout.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace springdrive::app::study_screen {

inline const Typeface &dejavu() {
    static const Typeface kTypeface;
    return kTypeface;
}

struct ScreenSize {
    int width;
    int height;
};
inline constexpr std::array kScreenSizes{ScreenSize{1280, 720}, ScreenSize{1920, 1080},
                                         ScreenSize{2560, 1440}, ScreenSize{800, 600}};

inline bool is_within(const PixelBox &inner, const PixelBox &outer) {
    return inner.is_empty() || (inner.x >= outer.x && inner.y >= outer.y &&
                                inner.x + inner.width <= outer.x + outer.width &&
                                inner.y + inner.height <= outer.y + outer.height);
}

inline bool overlap(const PixelBox &a, const PixelBox &b) {
    return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height &&
           b.y < a.y + a.height;
}

/// Boxes of which none may overlap another.
inline std::vector<PixelBox> separate_boxes(const ParticipantLayout &layout) {
    std::vector<PixelBox> boxes;
    for (const PixelBox &box :
         {layout.heading.box, layout.text.box, layout.scene, layout.left_bar, layout.left_text.box,
          layout.field, layout.footer.box, layout.progress}) {
        if (!box.is_empty()) {
            boxes.push_back(box);
        }
    }
    for (const PlacedChoice &choice : layout.choices) {
        boxes.push_back(choice.plate);
    }
    return boxes;
}

inline void expect_sound(const ParticipantPicture &picture, const ScreenSize &size) {
    const ParticipantLayout layout = lay_out(picture, size.width, size.height, dejavu());
    const PixelBox all{0, 0, size.width, size.height};
    const std::vector<PixelBox> boxes = separate_boxes(layout);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        ASSERT_TRUE(is_within(boxes[i], all));
        for (std::size_t k = 0; k < i; ++k) {
            ASSERT_FALSE(overlap(boxes[i], boxes[k]));
        }
    }
    ASSERT_EQ(layout.choices.size(), picture.choices.size());
    for (std::size_t i = 0; i < layout.choices.size(); ++i) {
        const PlacedChoice &choice = layout.choices[i];
        ASSERT_TRUE(is_within(choice.text.box, choice.plate));
        ASSERT_TRUE(is_within(choice.key, choice.plate));
        ASSERT_FALSE(overlap(choice.text.box, choice.key));
        ASSERT_EQ(layout.choice_at(choice.plate.x + 0.5 * choice.plate.width,
                                   choice.plate.y + 0.5 * choice.plate.height),
                  i);
    }
    if (picture.has_text_field) {
        ASSERT_TRUE(is_within(layout.typed.box, layout.field));
        ASSERT_TRUE(is_within(layout.cursor, layout.field));
    }
    if (!layout.calm_plate.is_empty()) {
        ASSERT_TRUE(is_within(layout.calm_plate, all));
        ASSERT_TRUE(is_within(layout.heading.box, layout.calm_plate));
        ASSERT_TRUE(is_within(layout.text.box, layout.calm_plate));
    }
    if (layout.is_readable) {
        for (const PlacedText *text : {&layout.text, &layout.footer, &layout.left_text}) {
            ASSERT_TRUE(text->lines.lines.empty() || text->lines.size_px >= size.height / 36.0);
        }
        ASSERT_TRUE(layout.heading.lines.lines.empty() ||
                    layout.heading.lines.size_px >= size.height / 24.0);
    }
}

} // namespace springdrive::app::study_screen
