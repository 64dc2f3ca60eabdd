// Covers app/study/{sitting,participant}: every screen that a participant comes to in the included
// protocols is sound and readable on each size of monitor.
#include "tests/app/study/participant_pictures.h"
#include "tests/app/study/sitting_rig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

struct Screen {
    SittingStep step = SittingStep::over;
    ParticipantPicture picture;
};

class StudyScreens : public StudySitting {
protected:
    /// Each screen once, whatever time is left, and wherever the ball is.
    void note(const ParticipantPicture &picture, SittingStep step) {
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
            if (now.state.step == SittingStep::questionnaire) {
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
            paused += now.state.step == SittingStep::paused ? 1 : 0;
            now.port.orders.is_paused =
                (now.port.orders.is_paused || pauses.is_now(now.state)) && paused < 20;
            stopped += now.state.step == SittingStep::device_stopped ? 1 : 0;
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
        now.port.orders.participant_leaves = now.state.step == SittingStep::warming_up;
    });
    EXPECT_TRUE(has(protocol_.texts.cooling_down));
    EXPECT_TRUE(has(protocol_.texts.done_early));
    protocol_.windings = {25.0, 26.0, 60.0};
    run_and_note("cold", [](const Moment &now) {
        now.port.orders.stops = now.state.step == SittingStep::warming_up;
    });
    EXPECT_TRUE(has(protocol_.texts.warming_up));
    kind_ = factory::DeviceKind::emulated;
    starts_at_zero_ = false;
    run_and_note("lost", [](const Moment &now) {
        now.port.orders.stops = now.state.step == SittingStep::device_lost;
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
