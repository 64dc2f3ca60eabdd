// Covers app/study/participant/participant_layout.cpp, choice_plates.cpp, participant_input.cpp,
// monitors.cpp.
#include "app/study/participant/monitors.h"
#include "app/study/participant/participant_input.h"
#include "app/study/participant/participant_layout.h"
#include "base/input_error.h"
#include "tests/app/study/participant_pictures.h"

#include <gtest/gtest.h>

#include <random>

namespace springdrive::app::study_screen {
namespace {

const Typeface &dejavu() {
    static const Typeface kTypeface;
    return kTypeface;
}

struct Size {
    int width;
    int height;
};
constexpr std::array kSizes{Size{1280, 720}, Size{1920, 1080}, Size{2560, 1440}, Size{800, 600}};

bool is_within(const PixelBox &inner, const PixelBox &outer) {
    return inner.is_empty() || (inner.x >= outer.x && inner.y >= outer.y &&
                                inner.x + inner.width <= outer.x + outer.width &&
                                inner.y + inner.height <= outer.y + outer.height);
}

bool overlap(const PixelBox &a, const PixelBox &b) {
    return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height &&
           b.y < a.y + a.height;
}

/// Boxes of which none may overlap another.
std::vector<PixelBox> separate_boxes(const ParticipantLayout &layout) {
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

void expect_sound(const ParticipantPicture &picture, const Size &size) {
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

TEST(ParticipantLayout, OfEveryScreenOfASittingIsSoundAndReadable) {
    for (const Size &size : kSizes) {
        for (const auto &[name, picture] : pictures_of_a_sitting()) {
            SCOPED_TRACE(name + " at height " + std::to_string(size.height));
            expect_sound(picture, size);
            EXPECT_TRUE(is_readable(picture, dejavu(), size.width, size.height));
        }
    }
}

std::string random_text(std::mt19937_64 &random, std::size_t most_words) {
    std::string text;
    for (std::size_t words = random() % (most_words + 1); words > 0; --words) {
        text.append(1 + random() % 12, static_cast<char>('a' + random() % 26));
        text += random() % 15 == 0 ? '\n' : ' ';
    }
    return text;
}

TEST(ParticipantLayout, OfRandomPicturesHasNothingOutsideOrOverlapping) {
    std::mt19937_64 random(11);
    for (int trial = 0; trial < 120; ++trial) {
        ParticipantPicture picture;
        picture.heading = random_text(random, 8);
        picture.text = random_text(random, 60);
        for (std::size_t left = random() % 8; left > 0; --left) {
            picture.choices.push_back({random_text(random, 4), random() % 4 == 0 ? "" : "1"});
        }
        picture.has_text_field = random() % 4 == 0;
        picture.typed = random_text(random, 40);
        picture.footer = random_text(random, 12);
        picture.progress = random() % 2 == 0 ? std::optional(0.5) : std::nullopt;
        picture.left_share = random() % 4 == 0 ? std::optional(0.5) : std::nullopt;
        picture.left_text = picture.left_share ? "0:42" : "";
        picture.scene = random() % 3 == 0 ? SceneShown::scene : SceneShown::nothing;
        picture.is_calm_stop = random() % 6 == 0;
        SCOPED_TRACE(trial);
        expect_sound(picture, kSizes.at(random() % kSizes.size()));
    }
}

TEST(ParticipantLayout, KeepsTheSceneWhereItIsWhateverIsAroundIt) {
    ParticipantPicture bare;
    bare.scene = SceneShown::scene;
    const PixelBox place = lay_out(bare, 1280, 720, dejavu()).scene;
    ASSERT_FALSE(place.is_empty());
    for (auto [name, picture] : pictures_of_a_sitting()) {
        picture.scene = SceneShown::scene;
        picture.has_text_field = false;
        picture.choices.resize(std::min<std::size_t>(picture.choices.size(), 2));
        picture.text.resize(std::min<std::size_t>(picture.text.size(), 60));
        EXPECT_EQ(lay_out(picture, 1280, 720, dejavu()).scene, place) << name;
    }
}

TEST(ParticipantLayout, SaysWhichTextIsTooLong) {
    ParticipantPicture picture;
    for (int i = 0; i < 60; ++i) {
        picture.text += "Some words that fill a line of it. ";
    }
    EXPECT_TRUE(is_readable(picture, dejavu()));
    for (int doubled = 0; doubled < 3; ++doubled) {
        picture.text += picture.text;
    }
    EXPECT_FALSE(is_readable(picture, dejavu()));
}

TEST(ParticipantInput, NamesKeysAsProtocolsSpellThem) {
    for (const char *name : {"1", "n", "Y", "left", "Right", "enter", "f5", "ü", "page_up"}) {
        EXPECT_TRUE(is_key_name(name)) << name;
    }
    for (const char *name : {"", " ", "space", "f12", "leftish", "ab"}) {
        EXPECT_FALSE(is_key_name(name)) << name;
    }
    EXPECT_TRUE(is_mouse_button_name("middle"));
    EXPECT_FALSE(is_mouse_button_name("1"));
    EXPECT_EQ(shown_key("left", false), "←");
    EXPECT_EQ(shown_key("left", true), "left");
    EXPECT_EQ(shown_key("n", false), "N");
}

TEST(ParticipantInput, TypesAndTakesBackWholeLetters) {
    const auto letter = [](const char *utf8) {
        return ParticipantInput{InputSource::letter, utf8, 0, 0.0, true};
    };
    const ParticipantInput back{InputSource::key, "backspace", 0, 0.0, true};
    ParticipantInput back_released = back;
    back_released.is_press = false;
    const std::vector<ParticipantInput> inputs{letter("a"), letter("ü"), letter("Ж"), back,
                                               back_released};
    EXPECT_EQ(typed_on("", inputs), "aü");
    EXPECT_EQ(typed_on("", inputs, 2), ""); // 'ü' and 'Ж' do not fit, 'a' is taken back
}

TEST(Monitor, IsMeantByNumberOrPartOfItsName) {
    const std::vector<MonitorFacts> there{
        {"eDP-1", 1920, 1200}, {"HDMI-1", 1920, 1080}, {"HDMI-10", 2560, 1440}};
    EXPECT_EQ(monitor_line(1, there[1]), "2: HDMI-1 1920×1080");
    EXPECT_EQ(monitor_meant("2", there), 1U);
    EXPECT_EQ(monitor_meant("edp", there), 0U);
    EXPECT_EQ(monitor_meant("hdmi-1", there), 1U); // all of a name goes before a part of one
    for (const char *wrong : {"0", "4", "hdmi", "DP-7", ""}) {
        EXPECT_THROW((void)monitor_meant(wrong, there), InputError) << wrong;
    }
}

} // namespace
} // namespace springdrive::app::study_screen
