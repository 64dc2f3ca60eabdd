// Covers app/study/sitting/{sitting,trial_presenter}.cpp: a device that is stopped or lost in a
// trial.
#include "base/error_text.h"
#include "tests/app/study/sitting_rig.h"
#include "tests/support/child_process.h"
#include "tests/support/full_disk.h"
#include "tests/support/modes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

using study::SessionEnding;
using study::Trial;

TEST_F(StudySitting, ATripIsStoredAndItsTrialComesAgain) {
    Once once(3);
    std::string shown;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &session) {
        port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
            if (once.is_now(state)) {
                session.servo().emergency_stop();
            }
            if (state.step == SittingStep::device_stopped) {
                shown = picture.text;
                port.orders.resets_device = true;
            }
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    EXPECT_EQ(shown, protocol_.texts.device_stopped);
    const std::vector<Trial> trials = study::read_study(file()).trials;
    const auto tripped = std::ranges::find_if(
        trials, [](const Trial &trial) { return !trial.safety_events.empty(); });
    ASSERT_NE(tripped, trials.end());
    EXPECT_EQ(tripped->place.position, 3);
    EXPECT_TRUE(std::holds_alternative<study::NoResponse>(tripped->response));
    EXPECT_TRUE(tripped->is_presented_again);
    EXPECT_EQ(
        std::ranges::count_if(
            trials, [&](const Trial &trial) { return trial.repetition_of == tripped->place; }),
        1);
}

/// Ten seconds, three times what another stop takes to be reset.
constexpr int kLongStop_frames = 600;

/// The experimenter waits before letting the device go on. @return frames for which it was stopped
int frames_stopped(MadeUpPort &port, const SittingState &state, int frames) {
    if (state.step == SittingStep::device_stopped) {
        ++frames;
        port.orders.resets_device = frames == kLongStop_frames;
    }
    return frames;
}

TEST_F(StudySitting, AStopByHandWaitsForTheExperimenter) {
    Once once(2);
    int stopped = 0;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            port.presses_emergency_stop = once.is_now(state);
            stopped = frames_stopped(port, state, stopped);
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    EXPECT_GE(stopped, kLongStop_frames);
    EXPECT_LE(stopped, kLongStop_frames + 2);
}

/// Of two stops the monitor knows the first. The second one is what somebody wants.
TEST_F(StudySitting, AStopByHandHoldsWhateverStoppedTheDeviceBefore) {
    kind_ = factory::DeviceKind::emulated;
    faults_ = {"brown-out:9@4-4.1"};
    int stopped = 0;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &session) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            stopped = frames_stopped(port, state, stopped);
            if (stopped == 30) {
                EXPECT_EQ(session.latest().safety.cause, servo::TripCause::board_fault);
                port.presses_emergency_stop = true;
            }
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    EXPECT_GE(stopped, kLongStop_frames);
    const std::vector<study::Note> notes = study::read_study(file()).notes;
    EXPECT_EQ(std::ranges::count(notes,
                                 "the emergency stop was pressed while the device was stopped",
                                 &study::Note::text),
              1);
}

/// A board's faults, and whether somebody wants the device stopped by them.
struct BoardStop {
    std::vector<std::string> faults;
    bool is_by_hand = false;
};

TEST_F(StudySitting, AStopByTheMonitorGoesOnByItselfAndOneByTheBoardsSwitchDoesNot) {
    kind_ = factory::DeviceKind::emulated;
    for (const BoardStop &one :
         {BoardStop{{"brown-out:9@4-4.1"}, false}, BoardStop{{"stop@4-6"}, true},
          BoardStop{{"brown-out:9@4-4.1", "stop@5-5.5"}, true}}) {
        SCOPED_TRACE(one.faults.back());
        faults_ = one.faults;
        int stopped = 0;
        static_cast<void>(run([&](MadeUpPort &port, session::Session &) {
            port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
                const int before = stopped;
                stopped = frames_stopped(port, state, stopped);
                port.orders.stops = before > 0 && before == stopped; // it goes on
            };
        }));
        if (one.is_by_hand) {
            EXPECT_GE(stopped, kLongStop_frames);
        } else {
            EXPECT_NEAR(stopped, 180, 5) << "three seconds";
        }
    }
}

/// The order was of the trip: a switch that is pressed after it holds.
TEST_F(StudySitting, AnOrderToGoOnIsNotOfASwitchThatIsPressedLater) {
    kind_ = factory::DeviceKind::emulated;
    faults_ = {"brown-out:9@4-4.1", "stop@5-5.5"};
    int tripped = 0;
    int stopped = 0;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &session) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            tripped += session.latest().safety.state == servo::SafetyState::tripped ? 1 : 0;
            port.orders.resets_device = tripped == 20;
            stopped = frames_stopped(port, state, stopped);
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    EXPECT_GE(stopped, kLongStop_frames);
}

/// Nor of one that is pressed in the same frame.
TEST_F(StudySitting, AStopHoldsAgainstAnOrderOfItsOwnFrame) {
    Once once(2);
    int stopped = 0;
    run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            stopped = frames_stopped(port, state, stopped);
            if (once.is_now(state)) {
                port.presses_emergency_stop = true;
                port.orders.resets_device = true;
            }
        };
    });
    EXPECT_GE(stopped, kLongStop_frames);
}

/// "Let the device go on" is of the stop that was there.
TEST_F(StudySitting, AnOrderToGoOnIsNotOfALaterStop) {
    Once once(2);
    int stopped = 0;
    bool is_pressed = false;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            port.orders.resets_device = state.step == SittingStep::after_response && !is_pressed;
            port.presses_emergency_stop = once.is_now(state);
            is_pressed = is_pressed || port.presses_emergency_stop;
            stopped = frames_stopped(port, state, stopped);
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    EXPECT_GE(stopped, kLongStop_frames);
}

/// Whoever presses it there and then goes: no trial tells of it.
TEST_F(StudySitting, AStopOutsideOfTrialsIsNotedAtOnce) {
    protocol_.questionnaire = {{"more", study::QuestionnaireTime::after, "Anything else?"}};
    for (const SittingStep step :
         {SittingStep::instructions, SittingStep::in_break, SittingStep::questionnaire}) {
        SCOPED_TRACE(description(step));
        const std::size_t before = study::read_study(file()).notes.size();
        int frames = 0; // since it was pressed
        const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
            port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
                port.presses_emergency_stop = state.step == step && frames == 0;
                frames += state.step == step || frames > 0 ? 1 : 0;
                port.orders.stops = frames == 3;
            };
        });
        EXPECT_EQ(ending, SessionEnding::stopped);
        const std::vector<study::Note> notes = study::read_study(file()).notes;
        ASSERT_EQ(notes.size(), before + 1);
        EXPECT_EQ(notes.back().kind, "safety");
        EXPECT_EQ(notes.back().participant, "P01");
    }
}

/// On a servo's own thread, whose stops are older than the last frame.
class DeviceStopsOfAThread : public StudySitting {
protected:
    DeviceStopsOfAThread()
        : session_(in_real_time(options())),
          stops_(session_, true, [this](auto what) { notes_.push_back(what); }) {
        session_.start();
        pass_until([this] { return state() == servo::SafetyState::running; });
        stops_.watch();
    }
    ~DeviceStopsOfAThread() override { session_.stop(); }

    static session::SessionOptions in_real_time(session::SessionOptions options) {
        options.lockstep = false;
        return options;
    }
    [[nodiscard]] servo::SafetyState state() const { return session_.latest().safety.state; }
    void pass_until(const std::function<bool()> &is_reached) {
        for (int frame = 0; frame < 1000 && !is_reached(); ++frame) {
            session_.advance(kMadeUpFrame_s);
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        ASSERT_TRUE(is_reached());
    }
    /// Between two frames.
    void stop_unseen() {
        session_.servo().emergency_stop();
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        ASSERT_EQ(state(), servo::SafetyState::running) << "as the last frame knew it";
    }

    session::Session session_;
    std::vector<std::string> notes_;
    DeviceStops stops_;
};

TEST_F(DeviceStopsOfAThread, AreSeenBeforeTheNextFrame) {
    stop_unseen();
    stops_.reset_when_calm();
    stops_.watch();
    EXPECT_EQ(stops_.count(), 1);
    EXPECT_EQ(notes_.size(), 1U);
    stops_.watch();
    EXPECT_EQ(stops_.count(), 1);
    stops_.let_go_on(); // of a stop that no frame has shown: without effect
    session_.advance(kMadeUpFrame_s);
    stops_.watch();
    EXPECT_EQ(state(), servo::SafetyState::tripped);
    EXPECT_EQ(stops_.count(), 1);
    session_.advance(kMadeUpFrame_s); // in which whoever saw it acts
    stops_.let_go_on();
    pass_until([this] { return state() == servo::SafetyState::running; });
    stops_.watch();
    EXPECT_EQ(stops_.count(), 1);
}

TEST_F(DeviceStopsOfAThread, InATrialAreOneWhicheverWayItEnds) {
    for (const bool is_stored : {true, false}) {
        const int before = stops_.count();
        const std::size_t notes = notes_.size();
        stops_.begin_trial();
        stop_unseen();
        stops_.end_trial(is_stored);
        stops_.watch();
        EXPECT_EQ(stops_.count(), before + 1);
        EXPECT_EQ(notes_.size(), is_stored ? notes : notes + 1);
        session_.advance(kMadeUpFrame_s); // shows it
        session_.advance(kMadeUpFrame_s); // in which whoever saw it acts
        stops_.let_go_on();
        pass_until([this] { return state() == servo::SafetyState::running; });
        stops_.watch();
    }
}

TEST_F(StudySitting, StopsInTrialsAndBetweenThemAreOneSum) {
    protocol_.stopping.max_trips = 2;
    Once in_trial(1);
    int between = 0;
    SittingStep before = SittingStep::over;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            if (state.step == SittingStep::setting_up && before != state.step &&
                !state.trials.empty() && between < 2) {
                port.presses_emergency_stop = true;
                ++between;
            }
            port.presses_emergency_stop = port.presses_emergency_stop || in_trial.is_now(state);
            port.orders.resets_device = state.step == SittingStep::device_stopped;
            before = state.step;
        };
    });
    EXPECT_EQ(ending, SessionEnding::safety_trip);
    EXPECT_TRUE(steps_.contains(SittingStep::over)) << "thanked";
    const study::StudyContents contents = study::read_study(file());
    EXPECT_EQ(std::ranges::count_if(
                  contents.trials, [](const Trial &trial) { return !trial.safety_events.empty(); }),
              1);
    EXPECT_EQ(std::ranges::count(contents.notes, "safety", &study::Note::kind), 2);
}

void set_plugged(session::Session &session, bool is_plugged) {
    session.servo().paused([&] { session.device().emulated()->set_plugged(is_plugged); });
}

TEST_F(StudySitting, ATrialInWhichTheCableIsPulledBeginsAnew) {
    kind_ = factory::DeviceKind::emulated;
    Once once(3);
    int lost = 0;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &session) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            if (once.is_now(state)) {
                set_plugged(session, false);
            }
            if (state.step == SittingStep::device_lost && ++lost == 60) {
                set_plugged(session, true);
            }
        };
    });
    EXPECT_GE(lost, 60);
    EXPECT_EQ(ending, SessionEnding::completed);
    expect_same_decisions(study::read_study(file()).trials, headless());
}

TEST_F(StudySitting, ADeviceThatIsNotZeroedIsNotDriven) {
    kind_ = factory::DeviceKind::emulated;
    starts_at_zero_ = false;
    int lost = 0;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &session) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            if (state.step != SittingStep::device_lost) {
                return;
            }
            EXPECT_FALSE(servo::lets_pass(session.latest().safety.state));
            // Four seconds, eight times what a tip must rest for the motors to start.
            if (++lost == 240) {
                session.follow_path(simulated::HandPath({{0.0, Vector3::Zero()}}));
            } else if (lost == 300) {
                session.zero_device(Vector3::Zero());
            }
            port.orders.stops = lost > 3000;
        };
    });
    EXPECT_GE(lost, 300);
    EXPECT_EQ(ending, SessionEnding::completed);
    expect_same_decisions(study::read_study(file()).trials, headless());
}

TEST_F(StudySitting, AStopWhileTheParticipantIsAskedComesAgain) {
    bool is_done = false;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &session) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            if (state.step == SittingStep::response && state.trial->place.block == 1 &&
                state.trial->place.position == 2 && !is_done) {
                session.servo().emergency_stop();
                is_done = true;
            }
            port.orders.resets_device = state.step == SittingStep::device_stopped;
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    const std::vector<Trial> trials = study::read_study(file()).trials;
    const auto stopped = std::ranges::find_if(
        trials, [](const Trial &trial) { return !trial.safety_events.empty(); });
    ASSERT_NE(stopped, trials.end());
    EXPECT_EQ(stopped->place.position, 2);
    EXPECT_TRUE(std::holds_alternative<study::NoResponse>(stopped->response));
    EXPECT_TRUE(stopped->is_presented_again);
    EXPECT_GT(stopped->safety_events.front().time_s, *stopped->presentations.back().end_s);
    EXPECT_TRUE(study::read_study(file()).notes.empty());
}

TEST_F(StudySitting, StopsBetweenTrialsAreNotedAndEndItWhenTheyAreTooMany) {
    protocol_.stopping.max_trips = 2;
    int reset = 0;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &session) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            if (state.step == SittingStep::setting_up) {
                session.servo().emergency_stop();
            }
            if (state.step == SittingStep::device_stopped) {
                port.orders.resets_device = true;
                ++reset;
            }
            port.orders.stops = reset > 600;
        };
    });
    EXPECT_EQ(ending, SessionEnding::safety_trip);
    const study::StudyContents contents = study::read_study(file());
    // It is pressed once more before the step that says so, which is a note of its own.
    EXPECT_EQ(std::ranges::count_if(contents.notes,
                                    [](const study::Note &note) {
                                        return note.kind == "safety" &&
                                               !note.text.ends_with("while the device was stopped");
                                    }),
              3);
    EXPECT_TRUE(contents.trials.empty());
    EXPECT_TRUE(steps_.contains(SittingStep::over)) << "thanked";
}

TEST_F(StudySitting, ARehearsalIsNotGoneOnWithOnAnotherDevice) {
    Once once(1);
    run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            port.orders.stops = once.is_now(state);
        };
    });
    kind_ = factory::DeviceKind::emulated;
    const std::string error = error_text_of([this] { run(); });
    EXPECT_NE(error.find("P01 has sessions on another kind of device (simulated)"),
              std::string::npos)
        << error;
    EXPECT_EQ(study::read_study(file()).sessions.size(), 1U);
}

/// The disk takes a part of a record: the trial is stored with that part, and a note says so.
TEST_F(StudySitting, NotesWhatARecordMisses) {
    keeps_records_ = true;
    const std::string said = testing::said_in_child(
        [] {},
        [&] {
            const testing::FullDisk disk(300'000);
            const SessionEnding ending = run([](MadeUpPort &port, session::Session &) {
                port.on_frame = [&port](const ParticipantPicture &, const SittingState &state) {
                    port.orders.stops = state.trials.size() == 1;
                };
            });
            return std::string(name_of(ending));
        });
    EXPECT_EQ(said, "stopped");
    const study::StudyContents contents = study::read_study(file());
    ASSERT_EQ(contents.trials.size(), 1U);
    ASSERT_TRUE(contents.trials.front().record);
    const auto noted = std::ranges::find(contents.notes, "record", &study::Note::kind);
    ASSERT_NE(noted, contents.notes.end());
    const std::filesystem::path record = folder_ / contents.trials.front().record->path;
    EXPECT_LE(std::filesystem::file_size(record), 300'000U);
    EXPECT_EQ(testing::mode_of(record), 0600U);
    EXPECT_TRUE(noted->text.starts_with(record.filename().string() + ": ")) << noted->text;
}

TEST_F(StudySitting, NotesNothingOfAWholeRecord) {
    keeps_records_ = true;
    run([](MadeUpPort &port, session::Session &) {
        port.on_frame = [&port](const ParticipantPicture &, const SittingState &state) {
            port.orders.stops = state.trials.size() == 1;
        };
    });
    const study::StudyContents contents = study::read_study(file());
    ASSERT_EQ(contents.trials.size(), 1U);
    EXPECT_TRUE(contents.trials.front().record);
    EXPECT_TRUE(contents.notes.empty());
}

} // namespace
} // namespace springdrive::app::study_screen
