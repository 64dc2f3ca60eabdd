// Covers app/study/session/{session,trial_presenter,device_stops}.cpp: a device that is stopped or
// lost, and a disk that is full.
#include "base/input_error.h"
#include "tests/app/study/made_up_people.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

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

/// Five seconds: another stop is reset after three.
constexpr int kLongStop_frames = 300;

/// The experimenter waits before letting the device go on. @return frames for which it was stopped
int frames_stopped(const Moment &now, int frames) {
    if (now.state.step == StudySessionStep::device_stopped) {
        ++frames;
        now.port.orders.resets_device = frames == kLongStop_frames;
    }
    return frames;
}

/// One while the participant is asked, and one in a presentation, for which nobody lets the device
/// go on for a while.
TEST_F(StudySessionTest, StopsAreStoredAndTheirTrialsComeAgain) {
    Once once(3);
    bool has_asked = false;
    int stopped = 0; // frames, in both
    std::string shown;
    const SessionEnding ending = run([&](const Moment &now) {
        const study::TrialPlace place =
            now.state.trial ? now.state.trial->place : study::TrialPlace{};
        const bool is_asked = now.state.step == StudySessionStep::response && place.block == 1 &&
                              place.position == 2 && !has_asked;
        has_asked = has_asked || is_asked;
        now.port.presses_emergency_stop = is_asked || once.is_now(now.state);
        if (now.state.step == StudySessionStep::device_stopped) {
            shown = now.picture.text;
            now.port.orders.resets_device = ++stopped == 1 || stopped == 1 + kLongStop_frames;
        }
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    EXPECT_EQ(shown, protocol_.texts.device_stopped);
    EXPECT_GE(stopped, 1 + kLongStop_frames);
    EXPECT_LE(stopped, 5 + kLongStop_frames);
    const std::vector<Trial> trials = contents().trials;
    int positions_stopped = 0;
    for (const Trial &trial : trials) {
        if (trial.safety_events.empty()) {
            continue;
        }
        positions_stopped = 10 * positions_stopped + trial.place.position;
        EXPECT_TRUE(std::holds_alternative<study::NoResponse>(trial.response));
        EXPECT_TRUE(trial.is_presented_again);
        EXPECT_EQ(
            std::ranges::count_if(
                trials, [&](const Trial &other) { return other.repetition_of == trial.place; }),
            1);
        if (trial.place.position == 2) {
            EXPECT_GT(trial.safety_events.front().time_s, *trial.presentations.back().end_s);
        }
    }
    EXPECT_EQ(positions_stopped, 23);
    EXPECT_TRUE(contents().notes.empty());
}

/// "Let the device go on" is of the stop that was there: of none in the frame of a later one, nor
/// before it.
TEST_F(StudySessionTest, AnOrderToGoOnIsNotOfAStopThatIsNewOrLater) {
    for (const StudySessionStep ordered_in :
         {StudySessionStep::interval, StudySessionStep::after_response}) {
        SCOPED_TRACE(description(ordered_in));
        begin_study("sitting");
        Once once(2);
        int stopped = 0;
        bool is_pressed = false;
        run([&](const Moment &now) {
            const int before = stopped;
            now.port.orders.resets_device = now.state.step == ordered_in &&
                                            ordered_in == StudySessionStep::after_response &&
                                            !is_pressed;
            stopped = frames_stopped(now, stopped);
            if (once.is_now(now.state)) {
                now.port.presses_emergency_stop = is_pressed = true;
                now.port.orders.resets_device = ordered_in == StudySessionStep::interval;
            }
            now.port.orders.stops = before > 0 && before == stopped; // it goes on
        });
        EXPECT_GE(stopped, kLongStop_frames);
    }
}

/// Of two stops the monitor knows the first; what holds is whether any was wanted by somebody, and
/// an order to go on is of those before it.
TEST_F(StudySessionTest, AStopThatSomebodyWantedHoldsAndOneByTheMonitorGoesOnByItself) {
    kind_ = factory::DeviceKind::emulated;
    struct Case {
        const char *name;
        std::vector<std::string> faults;
        int pressed_at; ///< frame of the stop in which somebody presses the emergency stop; 0: none
        int ordered_at; ///< in which the experimenter lets it go on, besides the end
        bool is_by_hand;
    };
    for (const Case &one :
         {Case{"monitor", {"brown-out:9@4-4.1"}, 0, 0, false},
          Case{"board's switch", {"stop@4-6"}, 0, 0, true},
          Case{"switch after the monitor", {"brown-out:9@4-4.1", "stop@5-5.5"}, 0, 0, true},
          Case{"pressed after the monitor", {"brown-out:9@4-4.1"}, 30, 0, true},
          Case{"ordered before the switch", {"brown-out:9@4-4.1", "stop@5-5.5"}, 0, 20, true}}) {
        SCOPED_TRACE(one.name);
        faults_ = one.faults;
        const std::size_t notes_before = contents().notes.size();
        int tripped = 0;
        int stopped = 0;
        static_cast<void>(run([&](const Moment &now) {
            const int before = stopped;
            tripped += now.session.latest().safety.state == servo::SafetyState::tripped ? 1 : 0;
            stopped = frames_stopped(now, stopped);
            if (one.ordered_at > 0 && tripped == one.ordered_at) {
                now.port.orders.resets_device = true;
            }
            if (one.pressed_at > 0 && stopped == one.pressed_at && before < stopped) {
                EXPECT_EQ(now.session.latest().safety.cause, servo::TripCause::board_fault);
                now.port.presses_emergency_stop = true;
            }
            now.port.orders.stops = before > 40 && before == stopped; // it goes on
        }));
        if (one.is_by_hand) {
            EXPECT_GE(stopped, kLongStop_frames);
        } else {
            EXPECT_NEAR(stopped, 180, 5) << "three seconds";
        }
        if (one.pressed_at > 0) {
            const std::vector<study::Note> notes = contents().notes;
            EXPECT_EQ(std::count_if(notes.begin() + static_cast<std::ptrdiff_t>(notes_before),
                                    notes.end(),
                                    [](const study::Note &note) {
                                        return note.text == "the emergency stop was pressed while "
                                                            "the device was stopped";
                                    }),
                      1);
        }
    }
}

/// Whoever presses it there and then goes: no trial tells of it.
TEST_F(StudySessionTest, AStopOutsideOfTrialsIsNotedAtOnce) {
    protocol_.practice = {};
    protocol_.breaks.every_trials = 1;
    std::get<study::ConstantStimuli>(protocol_.method).levels = {60.0};
    protocol_.questionnaire = {{"more", study::QuestionnaireTime::after, "Anything else?"}};
    for (const StudySessionStep step : {StudySessionStep::instructions, StudySessionStep::in_break,
                                        StudySessionStep::questionnaire}) {
        SCOPED_TRACE(description(step));
        const std::size_t before = contents().notes.size();
        int frames = 0; // since it was pressed
        const SessionEnding ending = run([&](const Moment &now) {
            now.port.presses_emergency_stop = now.state.step == step && frames == 0;
            frames += now.state.step == step || frames > 0 ? 1 : 0;
            now.port.orders.stops = frames == 3;
        });
        EXPECT_EQ(ending, SessionEnding::stopped);
        const std::vector<study::Note> notes = contents().notes;
        ASSERT_EQ(notes.size(), before + 1);
        EXPECT_EQ(notes.back().kind, "safety");
        EXPECT_EQ(notes.back().participant, "P01");
    }
}

/// On a servo's own thread, whose stops are older than the last frame.
class DeviceStopsOfAThread : public StudySessionTest {
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

TEST_F(StudySessionTest, StopsInTrialsAndBetweenThemAreOneSum) {
    protocol_.stopping.max_trips = 2;
    Once in_trial(1);
    int between = 0;
    const SessionEnding ending = run([&](const Moment &now) {
        const bool is_between = now.state.step == StudySessionStep::setting_up && now.is_new_step &&
                                !now.state.trials.empty() && between < 2;
        between += is_between ? 1 : 0;
        now.port.presses_emergency_stop = is_between || in_trial.is_now(now.state);
        now.port.orders.resets_device = now.state.step == StudySessionStep::device_stopped;
    });
    EXPECT_EQ(ending, SessionEnding::safety_trip);
    EXPECT_TRUE(steps_.contains(StudySessionStep::over)) << "thanked";
    const study::StudyContents stored = contents();
    EXPECT_EQ(std::ranges::count_if(
                  stored.trials, [](const Trial &trial) { return !trial.safety_events.empty(); }),
              1);
    EXPECT_EQ(std::ranges::count(stored.notes, "safety", &study::Note::kind), 2);
}

TEST_F(StudySessionTest, ATrialInWhichTheCableIsPulledBeginsAnew) {
    kind_ = factory::DeviceKind::emulated;
    // With V_b, a board that is not calibrated is softer than asked for, and its trials are marked.
    folders_ = {folder_, testing::assets()};
    protocol_.device_file = testing::write_phantom_without_brushes(folder_).filename().string();
    Once once(3);
    int lost = 0;
    const auto set_plugged = [](session::Session &session, bool is_plugged) {
        session.servo().paused([&] { session.device().emulated()->set_plugged(is_plugged); });
    };
    const SessionEnding ending = run([&](const Moment &now) {
        if (once.is_now(now.state)) {
            set_plugged(now.session, false);
        }
        if (now.state.step == StudySessionStep::device_lost && ++lost == 60) {
            set_plugged(now.session, true);
        }
    });
    EXPECT_GE(lost, 60);
    EXPECT_EQ(ending, SessionEnding::completed);
    expect_same_decisions(contents().trials, headless());
}

TEST_F(StudySessionTest, ADeviceThatIsNotZeroedIsNotDriven) {
    kind_ = factory::DeviceKind::emulated;
    starts_at_zero_ = false;
    int lost = 0;
    const SessionEnding ending = run([&](const Moment &now) {
        if (now.state.step == StudySessionStep::device_lost) {
            EXPECT_FALSE(servo::lets_pass(now.session.latest().safety.state));
            // Four seconds, eight times what a tip must rest for the motors to start.
            if (++lost == 240) {
                now.session.follow_path(simulated::HandPath({{0.0, Vector3::Zero()}}));
            } else if (lost == 300) {
                now.session.zero_device(Vector3::Zero());
            }
        }
        now.port.orders.stops = lost > 3000 || now.state.trials.size() == 1;
    });
    EXPECT_GE(lost, 300);
    EXPECT_LE(lost, 3000);
    EXPECT_EQ(ending, SessionEnding::stopped);
    ASSERT_EQ(contents().trials.size(), 1U);
    EXPECT_EQ(contents().trials[0].response, headless().at(0).response);
}

TEST_F(StudySessionTest, ARehearsalIsNotGoneOnWithOnAnotherDevice) {
    run([](const Moment &now) { now.port.orders.stops = true; });
    kind_ = factory::DeviceKind::emulated;
    const std::string error = error_text_of([this] { run(); });
    EXPECT_NE(error.find("P01 has sessions on another kind of device (simulated)"),
              std::string::npos)
        << error;
    EXPECT_EQ(contents().sessions.size(), 1U);
}

/// The disk takes a part of a record: the trial is stored with that part, and a note says so. Of a
/// whole record there is none.
TEST_F(StudySessionTest, NotesWhatARecordMisses) {
    keeps_records_ = true;
    const EachFrame one_trial_more = [](const Moment &now) {
        now.port.orders.stops =
            now.is_new_step && now.state.step == StudySessionStep::after_response;
    };
    run(one_trial_more);
    ASSERT_EQ(contents().trials.size(), 1U);
    EXPECT_TRUE(contents().trials.front().record);
    EXPECT_TRUE(contents().notes.empty());
    const std::string said =
        testing::said_in_child([] {},
                               [&] {
                                   const testing::FullDisk disk(300'000);
                                   return std::string(name_of(run(one_trial_more)));
                               });
    EXPECT_EQ(said, "stopped");
    const study::StudyContents stored = contents();
    ASSERT_EQ(stored.trials.size(), 2U);
    ASSERT_TRUE(stored.trials.back().record);
    ASSERT_EQ(stored.notes.size(), 1U);
    EXPECT_EQ(stored.notes.front().kind, "record");
    const std::filesystem::path record = folder_ / stored.trials.back().record->path;
    EXPECT_LE(std::filesystem::file_size(record), 300'000U);
    EXPECT_EQ(testing::mode_of(record), 0600U);
    EXPECT_TRUE(stored.notes.front().text.starts_with(record.filename().string() + ": "))
        << stored.notes.front().text;
}

} // namespace
} // namespace springdrive::app::study_screen
