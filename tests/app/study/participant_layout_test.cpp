// Covers app/study/participant/{participant_layout,letters,participant_input,participant_view}.cpp,
// and which monitor participant_window.cpp takes to be meant; and that every screen that a
// participant comes to in the included protocols is sound and readable on each size of monitor.
#include "app/study/participant/answers.h"
#include "app/study/participant/participant_layout.h"
#include "app/study/participant/participant_view.h"
#include "app/study/participant/participant_window.h"
#include "base/input_error.h"
#include "tests/app/study/made_up_people.h"
#include "tests/app/study/participant_pictures.h"

#include <gtest/gtest.h>
#include <imgui_internal.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

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
    for (auto [name, picture] : pictures_of_a_session()) {
        picture.scene = SceneShown::scene;
        picture.has_text_field = false;
        picture.choices.resize(std::min<std::size_t>(picture.choices.size(), 2));
        picture.text.resize(std::min<std::size_t>(picture.text.size(), 60));
        EXPECT_TRUE(laid_out(picture, kScreenSizes[0]).scene == place) << name;
    }
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
    const ImFont &font = letters.font(5.0F);
    EXPECT_EQ(font.FindGlyphNoFallback(u'漢'), nullptr);
    const ImFontGlyph *const box = font.FindGlyph(u'漢'); // a sign that is seen
    EXPECT_EQ(box, font.FindGlyphNoFallback(IM_UNICODE_CODEPOINT_INVALID));
    EXPECT_GT(box->X1, box->X0);
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
    struct Case {
        std::string text;
        float max_px;
        std::string lines; ///< with a stroke between them
        bool breaks_words;
    };
    for (const Case &one : {Case{"one two", width_of("one two") - 1.0F, "one|two|", false},
                            Case{"one two", width_of("one two") + 1.0F, "one two|", false},
                            Case{"one \t  two", width_of("one two"), "one|two|", false},
                            Case{" \t word", width_of("word") + 1.0F, "word|", false},
                            Case{"half-hour", width_of("half-ho"), "half-|hour|", false},
                            Case{"half\u2010hour", width_of("half-ho"), "half\u2010|hour|", false},
                            Case{"Rindfleischetikett", width_of("Rindfleisch") + 1.0F,
                                 "Rindfleisch|etikett|", true}}) {
        SCOPED_TRACE(one.text);
        const TextLines text = wrapped(one.text, font_of_20_px(), 20.0F, one.max_px);
        std::string lines;
        for (const TextLine &line : text.lines) {
            lines += line.text + "|";
        }
        EXPECT_EQ(lines, one.lines);
        EXPECT_EQ(text.breaks_words, one.breaks_words);
    }
}

TEST(ParticipantInput, NamesKeysAsProtocolsSpellThem) {
    for (const char *name : {"1", "n", "Y", "left", "Right", "enter", "f5", "ü", "page_up", "?",
                             "é", "ß", "ñ", "ж", "λ", "ע", "ض", "ก", "²"}) {
        EXPECT_TRUE(is_key_name(name)) << name;
    }
    for (const char *name : {"", " ", "space", "f12", "leftish", "ab", "ün", "\u00A0", "€", "Ä",
                             "Ж", "手", "한", "±", "＠", "\u0301", "\U0001F590", "\xff", "\xc3"}) {
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

OwnCurve sample_curve() {
    OwnCurve curve;
    curve.lowest_level = 2.0;
    curve.highest_level = 60.0;
    curve.ticks = {2.0, 5.0, 10.0, 20.0, 30.0, 60.0};
    curve.level_label = "how far the force was turned (degrees)";
    curve.share_label = "right answers";
    for (double level = 2.0; level <= 60.0; level *= 1.1) {
        const double share = 1.0 - 0.5 * std::exp(-std::pow(level / 15.0, 2.0));
        curve.course.push_back({level, share, share - 0.1, std::min(1.0, share + 0.1)});
    }
    curve.dots = {{2.0, 0.0, 1}, {11.0, 0.5, 4}, {20.0, 0.75, 16}, {60.0, 1.0, 3}};
    curve.threshold = {15.0, 9.0, 24.0};
    return curve;
}

CurveChart chart_in(const Rectangle &box, float text_px) {
    Letters &letters = letters_of(kScreenSizes[0]);
    letters.prepare(kScreenSizes[0].height, {});
    return arranged(sample_curve(), box, letters.font(text_px), text_px);
}

constexpr double kRoundOff_px = 1e-4; ///< three of a float below 1024, of 3e-5 each

TEST(CurveChart, PutsLevelsOnALogarithmicAxisAndSharesOnALinearOne) {
    const OwnCurve curve = sample_curve();
    const CurveChart chart = chart_in({{100, 50}, {800, 400}}, 20.0F);
    const Rectangle &plot = chart.plot;
    // 10 is the geometric mean of 5 and 20, and of 2 and 50.
    const float x = chart.x_px(curve, 10.0);
    EXPECT_NEAR(x, 0.5F * (chart.x_px(curve, 5.0) + chart.x_px(curve, 20.0)), kRoundOff_px);
    EXPECT_NEAR(x, 0.5F * (chart.x_px(curve, 2.0) + chart.x_px(curve, 50.0)), kRoundOff_px);
    EXPECT_FLOAT_EQ(chart.y_px(0.5), plot.corner.y + 0.5F * plot.size.y);
    EXPECT_FLOAT_EQ(chart.y_px(1.0), plot.corner.y);
    EXPECT_GT(chart.x_px(curve, 2.0), plot.corner.x);
    EXPECT_LT(chart.x_px(curve, 60.0), plot.corner.x + plot.size.x);
}

TEST(CurveChart, AreaOfADotIsItsNumberOfAnswers) {
    EXPECT_NEAR(std::pow(dot_radius_px(8, 400.0F) / dot_radius_px(2, 400.0F), 2.0), 4.0,
                1e-6); // four roundings of a float, of 6e-8 each, of 4
    EXPECT_EQ(dot_radius_px(kFullTrials, 400.0F), dot_radius_px(5 * kFullTrials, 400.0F));
    EXPECT_GT(dot_radius_px(1, 374.0F), 4.0F) << "one answer on a small screen has to be seen";
}

TEST(CurveChart, KeepsAllOfItInItsBox) {
    for (const auto &[box, text_px] : {std::pair{Rectangle{{190, 144}, {900, 374}}, 20.0F},
                                       std::pair{Rectangle{{285, 216}, {1350, 562}}, 29.0F}}) {
        const CurveChart chart = chart_in(box, text_px);
        EXPECT_TRUE(is_within(chart.plot, box));
        for (std::size_t i = 0; i < chart.labels.size(); ++i) {
            EXPECT_TRUE(is_within(chart.labels[i].box, box)) << i;
            for (std::size_t k = 0; k < i; ++k) {
                EXPECT_FALSE(overlap(chart.labels[i].box, chart.labels[k].box)) << k << ", " << i;
            }
        }
        ImDrawListSharedData shared;
        shared.SetCircleTessellationMaxError(0.3F);
        ImDrawList list(&shared);
        list._ResetForNewFrame();
        list.PushClipRect({0, 0}, {2000, 1000});
        draw_curve(chart, sample_curve(), list);
        ASSERT_GT(list.VtxBuffer.Size, 900);
        // Dots at 0 % and 100 % stand out of the plot by their radius.
        for (const ImDrawVert &vertex : list.VtxBuffer) {
            EXPECT_TRUE(box.contains(vertex.pos)) << vertex.pos.x << ", " << vertex.pos.y;
        }
    }
}

TEST(CurveChart, IsReadableWithTheWordsOfAVisitorsResult) {
    ParticipantPicture picture;
    picture.heading = "The made-up visitor feels a force that is turned by 48 degrees (39 to 58).";
    picture.text = "In truth it was 25 degrees. Larger dots are more answers.\n"
                   "Nothing of this is kept: no answer, no name, no file.";
    picture.choices = {{"Next visitor", "↵"}};
    picture.curve = sample_curve();
    for (const ScreenSize &size : {kScreenSizes[0], kScreenSizes[1]}) {
        const ParticipantLayout layout = laid_out(picture, size);
        const Rectangle &plot = layout.curve.plot;
        EXPECT_TRUE(layout.is_readable) << size.width;
        EXPECT_GT(plot.size.x, 0.5F * static_cast<float>(size.width));
        ASSERT_EQ(layout.choices.size(), 1U);
        EXPECT_LT(layout.text.box.corner.y + layout.text.box.size.y, plot.corner.y);
    }
}

struct Screen {
    StudySessionStep step = StudySessionStep::over;
    ParticipantPicture picture;
};

class StudyScreens : public StudySessionTest {
protected:
    /// Each screen once, whatever time is left, and wherever the ball is.
    void note(const ParticipantPicture &picture, StudySessionStep step) {
        const auto is_same = [&](const Screen &other) {
            return other.step == step && other.picture.heading == picture.heading &&
                   other.picture.text == picture.text && other.picture.choices == picture.choices &&
                   other.picture.scene == picture.scene &&
                   other.picture.typed.empty() == picture.typed.empty();
        };
        if (std::ranges::none_of(screens_, is_same)) {
            screens_.push_back({step, picture});
        }
    }

    void run_and_note(const std::string &name, const EachFrame &meanwhile) {
        begin_study("screens_" + name);
        static_cast<void>(run([&](const Moment &now) {
            note(now.picture, now.state.step);
            if (now.state.step == StudySessionStep::questionnaire) {
                answer(now.port, now.picture);
            }
            meanwhile(now);
        }));
    }

    [[nodiscard]] bool has(const std::string &heading_or_text) const {
        return std::ranges::any_of(screens_, [&](const Screen &screen) {
            return screen.picture.heading == heading_or_text ||
                   screen.picture.text == heading_or_text;
        });
    }

    std::vector<Screen> screens_;

private:
    /// A text is typed first; else the first choice.
    void answer(MadeUpPort &port, const ParticipantPicture &picture) {
        ParticipantInput input;
        input.source = InputSource::choice;
        if (picture.has_text_field && picture.typed.size() < 40) {
            input.source = InputSource::letter;
            input.name = picture.typed.size() % 6 == 5 ? " " : "ü";
        }
        port.inputs = {input};
    }
};

TEST_F(StudyScreens, OfTheIncludedProtocolsAreSoundAndReadable) {
    for (const char *name : {"direction", "stiffness", "blow", "hardness", "mass"}) {
        SCOPED_TRACE(name);
        const study::Protocol included = study::read_protocol_file(testing::assets() / "protocols" /
                                                                   (name + std::string(".toml")));
        const std::vector<double> levels = study::presentable_levels(included);
        protocol_ = short_protocol(name);
        protocol_.questionnaire = included.questionnaire;
        std::get<study::ConstantStimuli>(protocol_.method).levels = {levels.back()};
        protocol_.practice.levels = {levels.back()};
        Once stops(1);
        Once pauses(2);
        int paused = 0;
        int stopped = 0;
        run_and_note(name, [&](const Moment &now) {
            now.port.presses_emergency_stop = stops.is_now(now.state);
            paused += now.state.step == StudySessionStep::paused ? 1 : 0;
            now.port.orders.is_paused =
                (now.port.orders.is_paused || pauses.is_now(now.state)) && paused < 20;
            stopped += now.state.step == StudySessionStep::device_stopped ? 1 : 0;
            now.port.orders.resets_device = stopped == 20;
        });
        EXPECT_TRUE(has(protocol_.texts.end));
        EXPECT_TRUE(has(protocol_.texts.device_stopped));
        EXPECT_TRUE(has(protocol_.texts.paused));
        EXPECT_TRUE(has(protocol_.questionnaire.back().text));
    }
    protocol_ = short_protocol("direction");
    protocol_.windings = {25.0, 10.0, 20.0};
    run_and_note("hot", [](const Moment &now) {
        now.port.orders.participant_leaves = now.state.step == StudySessionStep::warming_up;
    });
    EXPECT_TRUE(has(protocol_.texts.cooling_down));
    EXPECT_TRUE(has(protocol_.texts.done_early));
    protocol_.windings = {25.0, 26.0, 60.0};
    run_and_note("cold", [](const Moment &now) {
        now.port.orders.stops = now.state.step == StudySessionStep::warming_up;
    });
    EXPECT_TRUE(has(protocol_.texts.warming_up));
    kind_ = factory::DeviceKind::emulated;
    starts_at_zero_ = false;
    run_and_note("lost", [](const Moment &now) {
        now.port.orders.stops = now.state.step == StudySessionStep::device_lost;
    });
    EXPECT_TRUE(has(protocol_.texts.device_lost));

    ASSERT_GT(screens_.size(), 50U);
    for (const Screen &screen : screens_) {
        SCOPED_TRACE(::testing::Message()
                     << description(screen.step) << ": " << screen.picture.heading << " / "
                     << screen.picture.text);
        for (const ScreenSize &size : kScreenSizes) {
            expect_sound(screen.picture, size);
            EXPECT_TRUE(laid_out(screen.picture, size).is_readable);
        }
    }
}

} // namespace
} // namespace springdrive::app::study_screen
