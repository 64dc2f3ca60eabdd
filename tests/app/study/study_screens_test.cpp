// Covers app/study/{sitting,participant}: every screen that a participant comes to in the included
// protocols is sound and readable on each size of monitor.
//
// With SPRINGDRIVE_PICTURES set to a folder, all are written there, to be looked at.
#include "app/study/participant/participant_view.h"
#include "tests/app/study/sitting_rig.h"
#include "tests/app/study/sound_layout.h"
#include "tests/support/hidden_window.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <stb/stb_image_write.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
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
            if (view_ != nullptr) {
                draw(screens_.back());
            }
        }
    }

    void run_and_note(const std::string &name,
                      const std::function<void(MadeUpPort &, session::Session &,
                                               const SittingState &)> &meanwhile) {
        name_ = name;
        folder_ = testing::fresh_folder("screens_" + name);
        study::create_study(file(), {protocol_.title, "text", "0.1.0"}, study::utc_now());
        study::StudyStore(file()).add({"P01", 1, study::utc_now()});
        static_cast<void>(run([&](MadeUpPort &port, session::Session &session) {
            port.on_scene = [&](const scene::Scene &scene, const scene::TouchSpot &spot) {
                if (view_ != nullptr) {
                    view_->set_scene(scene, {spot.point_m, spot.normal}, -0.09);
                }
            };
            port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
                note(picture, state.step);
                if (state.step == SittingStep::questionnaire) {
                    answer(port, picture);
                }
                meanwhile(port, session, state);
            };
        }));
    }

    [[nodiscard]] bool has(const std::string &heading_or_text) const {
        return std::ranges::any_of(screens_, [&](const Screen &screen) {
            return screen.picture.heading == heading_or_text ||
                   screen.picture.text == heading_or_text;
        });
    }

    std::vector<Screen> screens_;
    ParticipantView *view_ = nullptr; ///< to be looked at

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

    void draw(const Screen &screen) {
        for (const ScreenSize &size : kScreenSizes) {
            view_->draw(screen.picture, size.width, size.height);
            const std::vector<std::uint8_t> pixels = view_->pixels();
            const std::string file =
                fmt::format("{}/{}_{:02}_{}.png", std::getenv("SPRINGDRIVE_PICTURES"), name_,
                            screens_.size(), size.height);
            ASSERT_NE(stbi_write_png(file.c_str(), size.width, size.height, 3, pixels.data(),
                                     3 * size.width),
                      0)
                << file;
        }
    }

    std::string name_;
};

TEST_F(StudyScreens, OfTheIncludedProtocolsAreSoundAndReadable) {
    const testing::HiddenWindow window;
    ParticipantView view;
    if (std::getenv("SPRINGDRIVE_PICTURES") != nullptr) {
        view_ = &view;
    }
    for (const char *name : {"direction", "stiffness", "blow", "hardness", "mass"}) {
        SCOPED_TRACE(name);
        const study::Protocol included = study::read_protocol_file(testing::assets() / "protocols" /
                                                                   (name + std::string(".toml")));
        const std::vector<double> levels = study::presentable_levels(included);
        protocol_ = short_protocol(name);
        protocol_.questionnaire = included.questionnaire;
        std::get<study::ConstantStimuli>(protocol_.method).levels = {levels.front(), levels.back()};
        protocol_.practice.levels = {levels.back()};
        Once stops(1);
        Once pauses(2);
        int paused = 0;
        int stopped = 0;
        run_and_note(name,
                     [&](MadeUpPort &port, session::Session &session, const SittingState &state) {
                         if (stops.is_now(state)) {
                             session.servo().emergency_stop();
                         }
                         if (pauses.is_now(state)) {
                             port.orders.is_paused = true;
                         }
                         paused += state.step == SittingStep::paused ? 1 : 0;
                         port.orders.is_paused = port.orders.is_paused && paused < 20;
                         stopped += state.step == SittingStep::device_stopped ? 1 : 0;
                         port.orders.resets_device = stopped == 20;
                     });
        EXPECT_TRUE(has(protocol_.texts.end));
        EXPECT_TRUE(has(protocol_.texts.device_stopped));
        EXPECT_TRUE(has(protocol_.texts.paused));
        EXPECT_TRUE(has(protocol_.questionnaire.back().text));
    }
    protocol_ = short_protocol("direction");
    protocol_.windings = {25.0, 10.0, 20.0};
    run_and_note("hot", [](MadeUpPort &port, session::Session &, const SittingState &state) {
        port.orders.participant_leaves = state.step == SittingStep::warming_up;
    });
    EXPECT_TRUE(has(protocol_.texts.cooling_down));
    EXPECT_TRUE(has(protocol_.texts.done_early));
    protocol_.windings = {25.0, 26.0, 60.0};
    run_and_note("cold", [](MadeUpPort &port, session::Session &, const SittingState &state) {
        port.orders.stops = state.step == SittingStep::warming_up;
    });
    EXPECT_TRUE(has(protocol_.texts.warming_up));
    kind_ = factory::DeviceKind::emulated;
    starts_at_zero_ = false;
    run_and_note("lost", [](MadeUpPort &port, session::Session &, const SittingState &state) {
        port.orders.stops = state.step == SittingStep::device_lost;
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
