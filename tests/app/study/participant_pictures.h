// Pictures such as a participant sees, and what every layout of one must hold.
#pragma once

#include "app/study/participant/participant_layout.h"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app::study_screen {

struct ScreenSize {
    int width;
    int height;
};
inline constexpr std::array kScreenSizes{ScreenSize{1280, 720}, ScreenSize{1920, 1080},
                                         ScreenSize{2560, 1440}, ScreenSize{800, 600}};

/// Those of a screen, made once.
inline Letters &letters_of(const ScreenSize &size) {
    static std::map<int, Letters> all; // by height
    return all[size.height];
}

inline ParticipantLayout laid_out(const ParticipantPicture &picture, const ScreenSize &size) {
    return lay_out(picture, size.width, size.height, letters_of(size));
}

inline bool is_within(const Rectangle &inner, const Rectangle &outer) {
    return is_empty(inner) ||
           (inner.corner.x >= outer.corner.x && inner.corner.y >= outer.corner.y &&
            inner.corner.x + inner.size.x <= outer.corner.x + outer.size.x &&
            inner.corner.y + inner.size.y <= outer.corner.y + outer.size.y);
}

inline bool overlap(const Rectangle &a, const Rectangle &b) {
    return !is_empty(a) && !is_empty(b) && a.corner.x < b.corner.x + b.size.x &&
           b.corner.x < a.corner.x + a.size.x && a.corner.y < b.corner.y + b.size.y &&
           b.corner.y < a.corner.y + a.size.y;
}

/// Boxes of which none may overlap another.
inline std::vector<Rectangle> separate_boxes(const ParticipantLayout &layout) {
    std::vector<Rectangle> boxes;
    for (const Rectangle &box :
         {layout.heading.box, layout.text.box, layout.scene, layout.left_bar, layout.left_text.box,
          layout.field, layout.footer.box, layout.progress}) {
        if (!is_empty(box)) {
            boxes.push_back(box);
        }
    }
    for (const PlacedChoice &choice : layout.choices) {
        boxes.push_back(choice.card);
    }
    return boxes;
}

inline void expect_sound(const ParticipantPicture &picture, const ScreenSize &size) {
    const ParticipantLayout layout = laid_out(picture, size);
    const Rectangle all{{}, {static_cast<float>(size.width), static_cast<float>(size.height)}};
    const std::vector<Rectangle> boxes = separate_boxes(layout);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        ASSERT_TRUE(is_within(boxes[i], all));
        for (std::size_t k = 0; k < i; ++k) {
            ASSERT_FALSE(overlap(boxes[i], boxes[k]));
        }
    }
    ASSERT_EQ(layout.choices.size(), picture.choices.size());
    for (std::size_t i = 0; i < layout.choices.size(); ++i) {
        const PlacedChoice &choice = layout.choices[i];
        ASSERT_TRUE(is_within(choice.text.box, choice.card));
        ASSERT_TRUE(is_within(choice.key, choice.card));
        ASSERT_FALSE(overlap(choice.text.box, choice.key));
        ASSERT_EQ(layout.choice_at(choice.card.corner.x + 0.5 * choice.card.size.x,
                                   choice.card.corner.y + 0.5 * choice.card.size.y),
                  i);
    }
    if (picture.has_text_field) {
        ASSERT_TRUE(is_within(layout.typed.box, layout.field));
        ASSERT_TRUE(is_within(layout.cursor, layout.field));
    }
    if (!is_empty(layout.calm_plate)) {
        ASSERT_TRUE(is_within(layout.calm_plate, all));
        ASSERT_TRUE(is_within(layout.heading.box, layout.calm_plate));
        ASSERT_TRUE(is_within(layout.text.box, layout.calm_plate));
    }
    for (const TextLines *text : {&layout.heading, &layout.text, &layout.typed, &layout.footer}) {
        for (const TextLine &line : text->lines) {
            ASSERT_LE(line.width, text->box.size.x);
            ASSERT_LE(line.top + text->size_px, text->box.size.y);
        }
    }
    if (layout.is_readable) {
        for (const TextLines *text : {&layout.text, &layout.footer, &layout.left_text}) {
            ASSERT_TRUE(text->lines.empty() || text->size_px >= size.height / 36.0);
        }
        ASSERT_TRUE(layout.heading.lines.empty() || layout.heading.size_px >= size.height / 24.0);
    }
}

inline std::vector<std::pair<std::string, ParticipantPicture>> pictures_of_a_session() {
    const std::string stop = "You may stop the device at any time: press the space bar.";
    ParticipantPicture instructions;
    instructions.heading = "Which one is harder?";
    instructions.text =
        "Hold the stylus as you would hold a pen. You will feel something at its tip, twice.\n"
        "Press gently on the mark, as if to find out how hard it is, and lift the stylus again.\n"
        "Then answer the question. There is no hurry; if you are not sure, guess.";
    instructions.choices = {{"I am ready", "↵"}};
    instructions.footer = stop;
    ParticipantPicture question;
    question.heading = "In which interval did you feel it?";
    question.choices = {{"first", "1"}, {"second", "2"}};
    question.footer = stop;
    question.progress = 0.35;
    ParticipantPicture free_text;
    free_text.heading = "Was haben Sie gespürt?";
    free_text.text = "In eigenen Worten. Enter beendet die Eingabe.";
    free_text.has_text_field = true;
    free_text.typed = "Es fühlte sich an wie Holz, Ω und Ж ";
    ParticipantPicture trip;
    trip.heading = "The device has stopped itself, as it should.";
    trip.text = "Let go, and wait a moment. This one did not count, through no fault of yours.";
    trip.is_calm_stop = true;
    trip.progress = 0.5;
    ParticipantPicture scene;
    scene.heading = "1";
    scene.text = "Hold still above the mark.";
    scene.scene = SceneShown::scene;
    scene.tip_m = Vector3(0.0, 0.012, 0.0);
    scene.footer = stop;
    return {{"instructions", instructions},
            {"question", question},
            {"free_text", free_text},
            {"trip", trip},
            {"scene", scene}};
}

inline ParticipantPicture picture_of_a_session(const std::string &name) {
    for (const auto &[its_name, picture] : pictures_of_a_session()) {
        if (its_name == name) {
            return picture;
        }
    }
    throw std::out_of_range(name);
}

} // namespace springdrive::app::study_screen
