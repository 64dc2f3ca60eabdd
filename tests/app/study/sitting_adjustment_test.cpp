// Covers app/study/{sitting/sitting,participant/answers}.cpp: sessions by method of adjustment.
#include "app/study/participant/answers.h"
#include "tests/app/study/sitting_rig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <variant>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

using study::SessionEnding;
using study::Trial;

/// By method of adjustment: eta of the plate, from a drawn start.
study::Protocol adjusting_protocol() {
    study::Protocol protocol = short_protocol("stiffness");
    study::Adjustment method;
    method.scale = study::Scale::logarithmic;
    method.minimum_start = 0.05;
    method.maximum_start = 0.15;
    method.minimum_level = 0.01;
    method.maximum_level = 0.35;
    method.settings = 2;
    protocol.method = method;
    protocol.task.kind = study::TaskKind::adjustment;
    protocol.practice = {};
    protocol.responses.keys = {"left", "right", "enter"};
    protocol.timing.presentation_s = 3.0;
    protocol.blocks.resize(1);
    return protocol;
}

TEST_F(StudySitting, AnAdjustmentIsStoredAsItWasSet) {
    protocol_ = adjusting_protocol();
    constexpr int kSteps = 7;
    const auto is_first = [](const SittingState &state) {
        return state.trial->place.position == 1;
    };
    int pressed = 0;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            if (state.step != SittingStep::interval || !state.trial) {
                pressed = 0;
                return;
            }
            if (state.interval + 1 < state.intervals ||
                state.phase != study::StimulusPhase::presenting) {
                return;
            }
            // In the first trial less, in the others more, and beyond the end of the reach.
            const int steps = is_first(state) ? kSteps : 70;
            if (++pressed <= steps) {
                port.inputs = {MadeUpPort::key(is_first(state) ? "left" : "right", 0.0)};
            } else if (pressed == steps + 1) {
                port.inputs = {MadeUpPort::key("enter", 0.0)};
            }
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    const std::vector<Trial> trials = study::read_study(file()).trials;
    ASSERT_EQ(trials.size(), 2U);
    const double step = std::log(0.35 / 0.01) / 60.0; // 60 steps from one end to the other
    for (const Trial &trial : trials) {
        SCOPED_TRACE(text_of(trial.place));
        ASSERT_TRUE(std::holds_alternative<study::Adjusted>(trial.response));
        const double wanted =
            trial.place.position == 1 ? *trial.level * std::exp(-kSteps * step) : 0.35;
        EXPECT_NEAR(std::get<study::Adjusted>(trial.response).level, wanted, 1e-9 * wanted);
        EXPECT_TRUE(trial.marks.empty()) << trial.marks.front();
        const auto eta = std::ranges::find(trial.tuning, "eta", &study::Setting::name);
        ASSERT_NE(eta, trial.tuning.end());
        EXPECT_NEAR(std::get<double>(eta->value), 0.5 + wanted, 1e-9); // what was felt at the end
    }
}

TEST_F(StudySitting, AnAdjustmentThatIsNotEndedComesAgain) {
    protocol_ = adjusting_protocol();
    protocol_.timing.presentation_s = 1.0;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            if (state.step == SittingStep::interval && state.trial->place.position > 1) {
                port.inputs = {MadeUpPort::key("enter", 0.0)};
            }
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    const std::vector<Trial> trials = study::read_study(file()).trials;
    ASSERT_EQ(trials.size(), 3U);
    EXPECT_TRUE(std::holds_alternative<study::NoResponse>(trials[0].response));
    EXPECT_TRUE(trials[0].is_presented_again);
    EXPECT_EQ(std::get<study::Adjusted>(trials[1].response).level, *trials[1].level);
}

TEST_F(StudySitting, AStandardThatIsPresentedFirstIsCalledThat) {
    protocol_ = adjusting_protocol();
    protocol_.variable.shows_standard = true;
    std::set<std::string> headings;
    run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
            if (state.step == SittingStep::interval) {
                headings.insert(picture.heading);
            }
            port.orders.stops = state.step == SittingStep::after_response;
            if (state.interval == 1 && state.phase == study::StimulusPhase::presenting) {
                port.inputs = {MadeUpPort::key("enter", 0.0)};
            }
        };
    });
    EXPECT_EQ(headings,
              (std::set<std::string>{protocol_.texts.show_standard, protocol_.texts.question}));
}

} // namespace
} // namespace springdrive::app::study_screen
