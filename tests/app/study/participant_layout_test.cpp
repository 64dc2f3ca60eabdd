// Covers app/study/participant/participant_layout.cpp, letters.cpp, participant_input.cpp,
// monitors.cpp.
#include "app/study/participant/monitors.h"
#include "app/study/participant/participant_input.h"
#include "app/study/participant/participant_layout.h"
#include "base/input_error.h"
#include "tests/app/study/participant_pictures.h"
#include "tests/app/study/sound_layout.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace springdrive::app::study_screen {
namespace {

TEST(ParticipantLayout, OfEveryScreenOfASittingIsSoundAndReadable) {
    for (const ScreenSize &size : kScreenSizes) {
        for (const auto &[name, picture] : pictures_of_a_sitting()) {
            SCOPED_TRACE(name + " at height " + std::to_string(size.height));
            expect_sound(picture, size);
            EXPECT_TRUE(laid_out(picture, size).is_readable);
        }
    }
}

std::string random_text(std::mt19937_64 &random, std::size_t max_words) {
    std::string text;
    for (std::size_t words = random() % (max_words + 1); words > 0; --words) {
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
        expect_sound(picture, kScreenSizes.at(random() % kScreenSizes.size()));
    }
}

TEST(ParticipantLayout, KeepsTheSceneWhereItIsWhateverIsAroundIt) {
    ParticipantPicture bare;
    bare.scene = SceneShown::scene;
    const Rectangle place = laid_out(bare, kScreenSizes[0]).scene;
    ASSERT_FALSE(is_empty(place));
    for (auto [name, picture] : pictures_of_a_sitting()) {
        picture.scene = SceneShown::scene;
        picture.has_text_field = false;
        picture.choices.resize(std::min<std::size_t>(picture.choices.size(), 2));
        picture.text.resize(std::min<std::size_t>(picture.text.size(), 60));
        EXPECT_TRUE(laid_out(picture, kScreenSizes[0]).scene == place) << name;
    }
}

TEST(ParticipantLayout, SaysWhichTextIsTooLong) {
    ParticipantPicture picture;
    for (int i = 0; i < 60; ++i) {
        picture.text += "Some words that fill a line of it. ";
    }
    Letters letters;
    EXPECT_TRUE(is_readable(picture, letters));
    for (int doubled = 0; doubled < 3; ++doubled) {
        picture.text += picture.text;
    }
    EXPECT_FALSE(is_readable(picture, letters));
}

const ImFont &font_of_20_px() {
    static Letters letters;
    letters.prepare(720, {"Ж"});
    return letters.font(20.0F);
}

TEST(Letters, AreThoseOfLatinGreekAndCyrillicAndNoOthersThanTheFont) {
    Letters letters;
    letters.prepare(100, {"ÜłşΩЖ漢"});
    for (const ImWchar letter : u"azÄÖÜäöüßéçñøåłşαβΩЖйя←→↵“”–") {
        EXPECT_TRUE(letter == 0 || letters.font(5.0F).FindGlyphNoFallback(letter) != nullptr)
            << letter;
    }
    EXPECT_EQ(letters.font(5.0F).FindGlyphNoFallback(u'漢'), nullptr);
}

TEST(Letters, AreMadeAnewForAnotherHeightOrAlphabetOnly) {
    Letters letters;
    letters.prepare(100, {"some “words” →", "Grüße"});
    EXPECT_EQ(letters.version(), 1);
    letters.prepare(100, {"others"});
    EXPECT_EQ(letters.version(), 1);
    letters.prepare(100, {"Жук"});
    letters.prepare(100, {"Объявление"});
    EXPECT_EQ(letters.version(), 2);
    letters.prepare(200, {});
    EXPECT_EQ(letters.version(), 3);
}

TEST(WrappedText, LosesNoLetterAndKeepsToItsWidth) {
    std::mt19937_64 random(7);
    const std::vector<std::string> alphabet{"a", "e", "i", "n", "r", "s", "t", "l", "Ä", "ü",
                                            "ß", "Ω", "Ж", "-", ",", ".", " ", " ", " ", " "};
    for (int trial = 0; trial < 300; ++trial) {
        std::string text;
        for (std::size_t i = 1 + random() % 120; i > 0; --i) {
            text += random() % 40 == 0 ? "\n" : alphabet[random() % alphabet.size()];
        }
        const float max_px = 40.0F + static_cast<float>(random() % 400);
        const TextLines lines = wrapped(text, font_of_20_px(), 20.0F, max_px, 10.0F);
        std::string shown;
        float bottom = 0.0F;
        long gaps = 0;
        for (const TextLine &line : lines.lines) {
            ASSERT_LE(line.width, max_px);
            ASSERT_LE(line.width, lines.box.size.x);
            ASSERT_GE(line.top, bottom);
            gaps += line.top > bottom ? 1 : 0;
            bottom = line.top + 20.0F;
            shown += line.text;
        }
        ASSERT_EQ(bottom, lines.box.size.y);
        ASSERT_EQ(gaps, std::ranges::count(text, '\n'));
        const auto is_blank = [](char letter) { return letter == ' ' || letter == '\n'; };
        std::erase_if(text, is_blank);
        std::erase_if(shown, is_blank);
        ASSERT_EQ(shown, text);
    }
}

TEST(WrappedText, BreaksAtBlanksAndAWordOnlyWhereItIsLongerThanALine) {
    const auto width_of = [](const char *text) {
        return wrapped(text, font_of_20_px(), 20.0F, 1e4F).box.size.x;
    };
    const TextLines apart = wrapped("one two", font_of_20_px(), 20.0F, width_of("one two") - 1.0F);
    ASSERT_EQ(apart.lines.size(), 2U);
    EXPECT_EQ(apart.lines[0].text, "one");
    EXPECT_EQ(apart.lines[1].text, "two");
    EXPECT_FALSE(apart.breaks_words);
    EXPECT_EQ(wrapped("one two", font_of_20_px(), 20.0F, width_of("one two") + 1.0F).lines.size(),
              1U);
    EXPECT_TRUE(wrapped("Rindfleischetikett", font_of_20_px(), 20.0F, width_of("Rindfleisch"))
                    .breaks_words);
    const TextLines far_apart = wrapped("one \t  two", font_of_20_px(), 20.0F, width_of("one two"));
    ASSERT_EQ(far_apart.lines.size(), 2U);
    EXPECT_EQ(far_apart.lines[0].text, "one");
    EXPECT_EQ(far_apart.lines[1].text, "two");
    const TextLines indented = wrapped(" \t word", font_of_20_px(), 20.0F, width_of("word") + 1.0F);
    ASSERT_EQ(indented.lines.size(), 1U);
    EXPECT_EQ(indented.lines[0].text, "word");
    EXPECT_FALSE(indented.breaks_words);
    for (const std::string hyphen : {"-", "\u2010"}) {
        EXPECT_EQ(wrapped("half" + hyphen + "hour", font_of_20_px(), 20.0F, width_of("half-ho"))
                      .lines[0]
                      .text,
                  "half" + hyphen);
    }
}

TEST(ParticipantInput, NamesKeysAsProtocolsSpellThem) {
    for (const char *name : {"1", "n", "Y", "left", "Right", "enter", "f5", "ü", "page_up"}) {
        EXPECT_TRUE(is_key_name(name)) << name;
    }
    for (const char *name : {"", " ", "space", "f12", "leftish", "ab", "ün", "\u00A0"}) {
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
