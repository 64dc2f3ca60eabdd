// Covers app/visitors/{visits,unattended_visit}: whole visits on the simulated device, in
// lockstep, with visitors and a window that are made up. See visitors_window_test.cpp for the real
// window.
#include "app/visitors/visits.h"

#include "device/core/faults.h"
#include "engine/study/observers/simulated_sitting.h"
#include "engine/study/protocol/protocol_file.h"
#include "engine/study/protocol/session_plan.h"
#include "tests/app/study/made_up_people.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace springdrive::app::visitors {
namespace {

namespace fs = std::filesystem;

using study_screen::ParticipantInput;
using study_screen::ParticipantPicture;
using study_screen::SittingFrame;
using study_screen::SittingState;
using study_screen::SittingStep;

/// What visitors do is decided frame by frame: the key that is pressed, or none.
class MadeUpWindow {
public:
    using Act = std::function<std::string(const ParticipantPicture &, const SittingState &)>;

    MadeUpWindow(session::Session &session, Act act) : session_(session), act_(std::move(act)) {}

    SittingFrame show(const ParticipantPicture &picture, const SittingState &state) {
        session_.advance(study_screen::kMadeUpFrame_s);
        if (headings.empty() || headings.back() != picture.heading) {
            headings.push_back(picture.heading);
        }
        SittingFrame frame;
        const std::string key = act_(picture, state);
        if (!key.empty()) {
            frame.inputs.push_back(study_screen::MadeUpPort::key(key, session_.servo().now_s()));
        }
        frame.orders.stops = ends || ++frames_ > 60 * 900; // a quarter of an hour
        EXPECT_LE(frames_, 60 * 900) << "stuck at: " << picture.heading;
        return frame;
    }

    [[nodiscard]] bool has_shown(const std::string &heading) const {
        return std::ranges::any_of(headings, [&](const std::string &shown) {
            return shown.find(heading) != std::string::npos;
        });
    }

    std::vector<std::string> headings; ///< each that was not the one before
    bool ends = false;

private:
    session::Session &session_;
    Act act_;
    int frames_ = 0;
};

bool is_start(const ParticipantPicture &picture) { return picture.heading == "Can you feel it?"; }

class Visiting : public ::testing::Test {
protected:
    Visiting() : folders_{testing::assets() / "protocols", testing::assets()} {
        plan_.protocol = study::read_protocol_file(folders_.own / "can_you_feel_it.toml");
        plan_.setting = study::study_setting(plan_.protocol, folders_);
        plan_.folders = folders_;
        plan_.made_up = study::expected_observer(plan_.protocol);
        auto &method = std::get<study::QuestPlus>(plan_.protocol.method);
        method.min_trials = method.max_trials = 6; // a minute
    }

    /// Until `act` asks the window to end. @return the headings
    int run(MadeUpWindow::Act act, std::vector<std::string> *headings = nullptr) {
        session::SessionOptions options;
        options.scene = study::scene_file_of(plan_.protocol.conditions.front(), folders_);
        options.device.file = study::device_file_of(plan_.protocol, folders_);
        options.lockstep = true;
        if (!faults_.empty()) {
            options.device.kind = factory::DeviceKind::emulated;
            options.starts_at_zero = true;
            for (const char *fault : faults_) {
                options.emulation.faults.push_back(device::parse_fault(fault));
            }
        }
        session::Session session(options);
        session_ = &session;
        MadeUpWindow window(session,
                            [&](const ParticipantPicture &picture, const SittingState &state) {
                                return act(picture, state);
                            });
        window_ = &window;
        session.start();
        Visits visits(plan_, session, [](const scene::Scene &, const scene::TouchSpot &) {});
        study_screen::show_to_end(visits, window);
        if (headings != nullptr) {
            *headings = window.headings;
        }
        window_ = nullptr;
        session_ = nullptr;
        return visits.begun();
    }

    /// A visitor whose answers are drawn from a known function.
    [[nodiscard]] std::string answer_to(const SittingState &state) const {
        study::SimulatedParticipant visitor;
        visitor.function = plan_.made_up;
        const study::SimulatedAnswer answer =
            study::simulated_answer(plan_.protocol, visitor, *state.trial, *state.trial->level);
        const auto *chosen = std::get_if<study::Chosen>(&answer.response);
        return chosen != nullptr && chosen->alternative == 2 ? "2" : "1";
    }

    /// What somebody presses who does all that is asked for.
    [[nodiscard]] std::string willing(const ParticipantPicture &picture,
                                      const SittingState &state) const {
        if (is_start(picture)) {
            return plan_.has_device ? "enter" : "2";
        }
        switch (state.step) {
        case SittingStep::instructions:
        case SittingStep::practice_begins:
        case SittingStep::practice_ends:
            return "enter";
        case SittingStep::response:
            return answer_to(state);
        default:
            return {};
        }
    }

    study::ProtocolFolders folders_;
    VisitsPlan plan_;
    std::vector<const char *> faults_;    ///< of an emulated board; none: a simulated device
    session::Session *session_ = nullptr; ///< of the present run
    MadeUpWindow *window_ = nullptr;
};

TEST_F(Visiting, EndsWithTheVisitorsOwnCurve) {
    plan_.has_device = true;
    int answers = 0;
    run([&](const ParticipantPicture &picture, const SittingState &state) -> std::string {
        if (picture.curve && picture.choices.size() == 1) {
            EXPECT_EQ(picture.heading.find("You feel a force that is turned by "), 0U)
                << picture.heading;
            EXPECT_NE(picture.text.find("Nothing of this is kept"), std::string::npos);
            for (const study_screen::OwnCurve::Dot &dot : picture.curve->dots) {
                answers += dot.trials;
            }
            EXPECT_FALSE(picture.curve->course.empty());
            window_->ends = true;
        }
        return willing(picture, state);
    });
    EXPECT_EQ(answers, 6); // practice does not count
}

TEST_F(Visiting, SaysThatNothingCanBeFeltWithoutADevice) {
    std::string start;
    std::string result;
    run([&](const ParticipantPicture &picture, const SittingState &state) -> std::string {
        if (is_start(picture)) {
            start = picture.text;
        }
        if (picture.curve) {
            result = picture.heading;
            window_->ends = true;
        }
        return willing(picture, state);
    });
    EXPECT_NE(start.find("there is nothing to feel"), std::string::npos) << start;
    EXPECT_NE(result.find("These were guesses"), std::string::npos) << result;
}

TEST_F(Visiting, IsOverWhenTheVisitorWalksAwayAndBeginsAfreshForTheNext) {
    plan_.has_device = true;
    int starts = 0;
    bool is_at_start = false;
    double last_act_s = 0.0;
    double gone_s = 0.0;
    std::vector<std::pair<int, std::uint64_t>> first_trials; ///< place and key, a visitor each
    std::vector<double> progress_at_begin;
    bool is_new = false;
    std::vector<std::string> headings;
    const int begun = run(
        [&](const ParticipantPicture &picture, const SittingState &state) -> std::string {
            const double now_s = session_->servo().now_s();
            if (is_start(picture) && !std::exchange(is_at_start, true)) {
                ++starts;
                is_new = true;
                gone_s = starts == 2 ? now_s : gone_s;
            }
            is_at_start = is_start(picture);
            if (state.step == SittingStep::interval && is_new) {
                is_new = false;
                first_trials.emplace_back(state.trial->place.position, state.trial->seed);
                progress_at_begin.push_back(state.progress);
            }
            window_->ends = first_trials.size() == 2;
            // The first visitor leaves after two trials.
            if (starts == 1 && state.trials.size() >= 2) {
                return {};
            }
            const std::string key = willing(picture, state);
            last_act_s = starts == 1 && !key.empty() ? now_s : last_act_s;
            return key;
        },
        &headings);
    EXPECT_EQ(begun, 2);
    EXPECT_NEAR(gone_s - last_act_s, kGoneAfter_s, 0.1); // six frames
    EXPECT_EQ(std::ranges::count(headings, "Still there?"), 1);
    ASSERT_EQ(first_trials.size(), 2U);
    EXPECT_EQ(first_trials[0].first, 1);
    EXPECT_EQ(first_trials[1].first, 1);
    EXPECT_NE(first_trials[0].second, first_trials[1].second) << "the same trials again";
    EXPECT_EQ(progress_at_begin, (std::vector<double>{0.0, 0.0}));
}

TEST_F(Visiting, StaysForAVisitorWhoAnswersStillThere) {
    plan_.has_device = true;
    bool was_asked = false;
    bool was_at_start = false;
    std::vector<std::string> headings;
    run(
        [&](const ParticipantPicture &picture, const SittingState &state) -> std::string {
            if (picture.heading == "Still there?") {
                was_asked = true;
                return "x";
            }
            was_at_start = was_at_start || (was_asked && is_start(picture));
            window_->ends = picture.curve.has_value();
            return state.trials.size() >= 2 && !was_asked ? std::string() : willing(picture, state);
        },
        &headings);
    EXPECT_TRUE(was_asked);
    EXPECT_FALSE(was_at_start);
}

/// Or a stopped device would go on for somebody who only said so.
TEST_F(Visiting, WhatAnswersStillThereDoesNothingElse) {
    plan_.has_device = true;
    bool was_asked = false;
    int read_on = 0; ///< frames of the instructions after that
    run([&](const ParticipantPicture &picture, const SittingState &state) -> std::string {
        if (picture.heading == "Still there?") {
            EXPECT_EQ(picture.choices.size(), 1U);
            was_asked = true;
            return "enter"; // which would leave the instructions, too
        }
        if (!is_start(picture) && state.step == SittingStep::instructions) {
            read_on += was_asked ? 1 : 0;
            return read_on > 3 ? "enter" : "";
        }
        window_->ends = state.step == SittingStep::interval;
        return willing(picture, state);
    });
    EXPECT_TRUE(was_asked);
    EXPECT_GT(read_on, 3);
}

TEST_F(Visiting, IsLeftByEscape) {
    plan_.has_device = true;
    int starts = 0;
    bool is_at_start = false;
    run([&](const ParticipantPicture &picture, const SittingState &state) -> std::string {
        starts += is_start(picture) && !is_at_start ? 1 : 0;
        is_at_start = is_start(picture);
        window_->ends = starts == 2;
        return state.step == SittingStep::interval ? "escape" : willing(picture, state);
    });
    EXPECT_EQ(starts, 2);
}

TEST_F(Visiting, GoesOnAfterAStopByHandWhenTheVisitorWants) {
    plan_.has_device = true;
    bool was_stopped = false;
    int frames_stopped = 0;
    bool has_curve = false;
    run([&](const ParticipantPicture &picture, const SittingState &state) -> std::string {
        if (state.step == SittingStep::interval && state.trials.size() == 2 &&
            !std::exchange(was_stopped, true)) {
            session_->servo().emergency_stop();
        }
        if (state.step == SittingStep::device_stopped) {
            return ++frames_stopped == 300 ? "enter" : ""; // longer than it resets itself
        }
        has_curve = has_curve || picture.curve.has_value();
        window_->ends = has_curve;
        return willing(picture, state);
    });
    EXPECT_GE(frames_stopped, 300);
    EXPECT_TRUE(has_curve);
}

/// The next visitor finds a stopped device that only somebody's wish lets go on. The monitor knows
/// no more than what stopped it first.
TEST_F(Visiting, AStopByHandOutlastsTheVisit) {
    for (const auto &[faults, is_pressed] :
         {std::pair<std::vector<const char *>, bool>{{"stop@4-4.5"}, false},
          {{"brown-out:9@4-4.1", "stop@5-5.5"}, false},
          {{"brown-out:9@4-4.1"}, true}}) {
        SCOPED_TRACE(faults.back());
        plan_.has_device = true;
        faults_ = faults;
        int starts = 0;
        bool is_at_start = false;
        int frames_stopped = 0; ///< of both visits
        bool ran_again = false;
        run([&](const ParticipantPicture &picture, const SittingState &state) -> std::string {
            starts += is_start(picture) && !is_at_start ? 1 : 0;
            is_at_start = is_start(picture);
            if (state.step == SittingStep::device_stopped) {
                if (starts == 1) {
                    ++frames_stopped;
                    if (frames_stopped == 60 && is_pressed) {
                        session_->servo().emergency_stop();
                    }
                    return frames_stopped == 120 ? "escape" : ""; // before it resets itself
                }
                frames_stopped = std::max(frames_stopped, 120);
                EXPECT_NE(session_->latest().safety.state, servo::SafetyState::running);
                return ++frames_stopped == 120 + 600 ? "enter" : ""; // ten seconds
            }
            ran_again = starts == 2 && state.step == SittingStep::interval;
            window_->ends = ran_again;
            return willing(picture, state);
        });
        EXPECT_GE(frames_stopped, 120 + 600);
        EXPECT_TRUE(ran_again);
    }
}

/// Their keys are no answers, and stop the device whatever is on the screen.
TEST_F(Visiting, WhoStopsTheDeviceIsStillThere) {
    plan_.has_device = true;
    bool was_asked = false;
    int frames_stopped = 0;
    bool is_at_start_again = false;
    run([&](const ParticipantPicture &picture, const SittingState &state) -> std::string {
        if (picture.heading == "Still there?" && !std::exchange(was_asked, true)) {
            session_->servo().emergency_stop();
            return {};
        }
        is_at_start_again = is_at_start_again || (was_asked && is_start(picture));
        frames_stopped += was_asked && picture.heading != "Still there?" ? 1 : 0;
        window_->ends = is_at_start_again || frames_stopped == 60 * 20;
        return was_asked || state.step == SittingStep::instructions
                   ? (is_start(picture) ? "enter" : "")
                   : willing(picture, state);
    });
    EXPECT_TRUE(was_asked);
    EXPECT_FALSE(is_at_start_again) << "within twenty seconds";
}

TEST_F(Visiting, FastMotionIsLeftByEscapeWithoutACurve) {
    int starts = 0;
    bool is_at_start = false;
    bool has_result = false;
    run([&](const ParticipantPicture &picture, const SittingState &) -> std::string {
        starts += is_start(picture) && !is_at_start ? 1 : 0;
        is_at_start = is_start(picture);
        has_result = has_result || (picture.curve && !picture.choices.empty());
        window_->ends = starts == 2 || has_result;
        return is_at_start ? "1" : picture.curve ? "escape" : "";
    });
    EXPECT_EQ(starts, 2);
    EXPECT_FALSE(has_result);
}

TEST_F(Visiting, ShowsAMadeUpVisitorAndReckonsTheRest) {
    int shown = 0;
    std::vector<int> growing; ///< answers in the curve
    std::string heading;
    std::string text;
    run([&](const ParticipantPicture &picture, const SittingState &state) -> std::string {
        if (is_start(picture)) {
            return "1";
        }
        shown = std::max(shown, static_cast<int>(state.trials.size()));
        if (picture.curve) {
            int answers = 0;
            for (const study_screen::OwnCurve::Dot &dot : picture.curve->dots) {
                answers += dot.trials;
            }
            if (growing.empty() || growing.back() != answers) {
                growing.push_back(answers);
            }
            heading = picture.heading;
            text = picture.text;
            window_->ends = !picture.choices.empty();
        }
        return {};
    });
    EXPECT_EQ(shown, static_cast<int>(UnattendedVisit::kShownTrials));
    EXPECT_EQ(growing, (std::vector<int>{3, 4, 5, 6}));
    EXPECT_EQ(heading.find("The made-up visitor feels a force that is turned by "), 0U) << heading;
    EXPECT_NE(text.find("In truth it was 25 degrees."), std::string::npos) << text;
}

/// A visitor who is made up is nobody who could let it go on.
TEST_F(Visiting, AShowThatWasStoppedWaitsForAPerson) {
    bool was_stopped = false;
    bool has_curve = false;
    int frames_stopped = 0;
    run([&](const ParticipantPicture &picture, const SittingState &state) -> std::string {
        if (state.step == SittingStep::interval && !std::exchange(was_stopped, true)) {
            session_->servo().emergency_stop();
        }
        if (state.step == SittingStep::device_stopped) {
            return ++frames_stopped == 3600 ? "enter" : ""; // a minute
        }
        has_curve = has_curve || picture.curve.has_value();
        window_->ends = has_curve;
        return is_start(picture) ? "1" : "";
    });
    EXPECT_GE(frames_stopped, 3600);
    EXPECT_TRUE(has_curve);
}

/// A show goes on by itself: nobody presses anything.
TEST_F(Visiting, AShowGoesFromVisitorToVisitor) {
    plan_.is_show = true;
    int starts = 0;
    bool is_at_start = false;
    const int begun =
        run([&](const ParticipantPicture &picture, const SittingState &) -> std::string {
            starts += is_start(picture) && !is_at_start ? 1 : 0;
            is_at_start = is_start(picture);
            window_->ends = starts == 3;
            return {};
        });
    EXPECT_EQ(begun, 2);
}

/// Names and sizes of all files below.
std::vector<std::pair<fs::path, std::uintmax_t>> listing(const fs::path &folder) {
    std::vector<std::pair<fs::path, std::uintmax_t>> files;
    for (const fs::directory_entry &entry : fs::recursive_directory_iterator(folder)) {
        files.emplace_back(entry.path(), entry.is_regular_file() ? entry.file_size() : 0);
    }
    std::ranges::sort(files);
    return files;
}

TEST_F(Visiting, LeavesNoFile) {
    const fs::path folder = testing::fresh_folder("visits");
    const fs::path before = fs::current_path();
    fs::copy(folders_.own, folder, fs::copy_options::recursive);
    plan_.folders.own = folder; // beside the protocol, or where the program runs
    fs::current_path(folder);
    const auto then = listing(folder);
    plan_.has_device = true;
    run([&](const ParticipantPicture &picture, const SittingState &state) -> std::string {
        if (state.step == SittingStep::interval && state.trials.size() == 3) {
            EXPECT_EQ(listing(folder), then) << "in the midst of a visit";
        }
        window_->ends = picture.curve.has_value();
        return willing(picture, state);
    });
    fs::current_path(before);
    EXPECT_EQ(listing(folder), then);
}

} // namespace
} // namespace springdrive::app::visitors
