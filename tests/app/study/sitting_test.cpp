// Covers app/study/sitting/{sitting,trial_presenter}.cpp: whole sessions, what an experimenter may
// do in them, and that they go on. See study_window_test.cpp for the real windows.
#include "tests/app/study/sitting_rig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

using study::SessionEnding;
using study::Trial;

TEST_F(StudySitting, StoresWhatTheSameDecisionsGiveHeadless) {
    const SessionEnding ending = run();
    EXPECT_EQ(ending, SessionEnding::completed);
    const std::vector<Trial> trials = study::read_study(file()).trials;
    expect_same_decisions(trials, headless());
    for (const SittingStep step :
         {SittingStep::instructions, SittingStep::practice_begins, SittingStep::practice_ends,
          SittingStep::in_break, SittingStep::interval, SittingStep::response, SittingStep::over}) {
        EXPECT_TRUE(steps_.contains(step)) << description(step);
    }
    for (const Trial &trial : trials) {
        ASSERT_EQ(trial.presentations.size(), 2U);
        if (trial.response_time_s) {
            // The question comes when the hand has left, at most half a second after the end.
            EXPECT_GE(*trial.response_time_s, 0.3);
            EXPECT_LE(*trial.response_time_s, 1.0);
        }
    }
}

TEST_F(StudySitting, GoesOnAfterAStopAsIfUndisturbed) {
    for (const int position : {2, 3}) {
        Once once(position);
        const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
            port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
                port.orders.stops = once.is_now(state);
            };
        });
        EXPECT_EQ(ending, SessionEnding::stopped);
    }
    EXPECT_EQ(run(), SessionEnding::completed);
    EXPECT_EQ(study::read_study(file()).sessions.size(), 3U);
    expect_same_decisions(study::read_study(file()).trials, headless());
}

TEST_F(StudySitting, PausesBreaksAndRepeatsAsTheExperimenterWants) {
    Once pauses(2);
    Once repeats(4);
    Once breaks(5);
    int paused = 0;
    int in_break = 0;
    int break_of = 0;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            if (pauses.is_now(state)) {
                port.orders.is_paused = true;
            }
            if (state.step == SittingStep::paused && ++paused == 120) {
                port.orders.is_paused = false;
            }
            port.orders.repeats = port.orders.repeats || repeats.is_now(state);
            if (breaks.is_now(state)) {
                port.orders.skips_to_break = true;
                in_break = 0;
                break_of = 1;
            }
            if (state.step == SittingStep::in_break && break_of == 1) {
                ++in_break;
            }
            if (state.trial && state.trial->place.position == 6) {
                break_of = 2;
            }
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    EXPECT_EQ(paused, 120);
    EXPECT_GE(in_break, 59); // a second
    const std::vector<Trial> trials = study::read_study(file()).trials;
    const auto repeated = std::ranges::find_if(trials, [](const Trial &trial) {
        return std::ranges::count(trial.marks, "repeated at the experimenter's wish") > 0;
    });
    ASSERT_NE(repeated, trials.end());
    EXPECT_EQ(repeated->place.position, 4);
    EXPECT_TRUE(repeated->is_presented_again);
}

/// Every trial is marked, and none repeated but without an answer, or at the experimenter's wish.
TEST_F(StudySitting, SaysThatATrialComesAgainIfItDoes) {
    protocol_.marking.repeats = false;
    protocol_.marking.direction_deg = 1e-9;
    protocol_.marking.max_marked = 100;
    std::set<study::TrialPlace> announced;
    std::set<study::TrialPlace> wanted;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
            if (state.step == SittingStep::after_response &&
                picture.text == protocol_.texts.repeated) {
                announced.insert(state.trial->place);
            }
            if (state.step == SittingStep::response && state.trial->place.position % 3 == 0 &&
                state.trial->place.attempt == 1) {
                port.orders.repeats = true;
                wanted.insert(state.trial->place);
            }
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    int once_only = 0;
    int answered_and_wanted = 0;
    for (const Trial &trial : study::read_study(file()).trials) {
        const bool has_answer = !std::holds_alternative<study::NoResponse>(trial.response);
        EXPECT_FALSE(trial.marks.empty());
        EXPECT_EQ(announced.contains(trial.place), !has_answer) << text_of(trial.place);
        EXPECT_EQ(trial.is_presented_again, !has_answer || wanted.contains(trial.place));
        once_only += trial.is_presented_again ? 0 : 1;
        answered_and_wanted += has_answer && wanted.contains(trial.place) ? 1 : 0;
    }
    EXPECT_FALSE(announced.empty());
    EXPECT_GT(once_only, 0);
    EXPECT_GT(answered_and_wanted, 0);
}

/// As the included protocol warms them, for a minute and a half: R̂ must follow the heat of a
/// current whose mean is zero, or dR and stiffness are others than intended.
TEST_F(StudySitting, PresentsWhatIsIntendedAfterAWarmUp) {
    protocol_.windings =
        study::read_protocol_file(testing::assets() / "protocols/direction.toml").windings;
    int frames_warming = 0;
    run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            port.orders.stops = state.trials.size() == 6;
            frames_warming += state.step == SittingStep::warming_up ? 1 : 0;
        };
    });
    EXPECT_GT(frames_warming, 60 * 60);
    const std::vector<Trial> trials = study::read_study(file()).trials;
    ASSERT_EQ(trials.size(), 6U);
    for (const Trial &trial : trials) {
        const bool has_answer = !std::holds_alternative<study::NoResponse>(trial.response);
        EXPECT_EQ(trial.marks.empty(), has_answer) << trial.marks.front();
        for (const study::Presentation &presentation : trial.presentations) {
            for (const study::StimulusValue &value : presentation.values) {
                if (value.name == "stiffness_N_per_m") {
                    EXPECT_NEAR(*value.delivered / *value.intended, 1.0,
                                0.01 * protocol_.marking.stiffness_percent);
                }
            }
        }
    }
}

/// Wherever the hand is when a trial begins, and however long it takes to come to rest: one that
/// sets out too early is seen to rest only when its course is over.
TEST(TrialPresenter, ALedHandSetsOutOnlyWhenItHasRested) {
    const study::ProtocolFolders folders{testing::assets() / "protocols", testing::assets()};
    for (const std::string name : {"hardness", "stiffness", "mass", "blow"}) {
        const study::Protocol protocol = short_protocol(name);
        const std::vector<double> level{0.3 * protocol.variable.standard};
        const study::PlannedTrial planned = trials_of_conditions(protocol, level, {1}).front();
        for (int away_mm = 0; away_mm <= 20; ++away_mm) {
            SCOPED_TRACE(name + ", " + std::to_string(away_mm) + " mm away");
            present_alone(
                protocol, folders, planned, [](MadeUpPort &) {},
                [&](session::Session &session) {
                    const Vector3 away_m = 1e-3 * away_mm * Vector3::UnitY();
                    session.follow_path(
                        simulated::HandPath({{0.0, session.hand().target_m() + away_m}}));
                    session.advance(0.2 + 0.02 * away_mm + 0.013 * (away_mm % 7));
                });
        }
    }
}

/// When the hand is off: an experimenter may want to say something.
TEST_F(StudySitting, APauseInTheWarmUpIsObeyedBeforeTheTrial) {
    protocol_.windings = {25.0, 26.0, 60.0};
    int paused = 0;
    run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            paused += state.step == SittingStep::paused ? 1 : 0;
            port.orders.is_paused =
                (state.step == SittingStep::warming_up || state.step == SittingStep::paused) &&
                paused < 100;
            EXPECT_TRUE(state.step != SittingStep::interval || paused == 100);
            port.orders.stops = state.trials.size() == 1;
        };
    });
    EXPECT_EQ(paused, 100);
}

TEST_F(StudySitting, AnswersAreStoredWhateverEndsTheSessionInTheFeedback) {
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
            port.orders.stops = state.step == SittingStep::after_response &&
                                (!picture.heading.empty() || !picture.text.empty());
        };
    });
    EXPECT_EQ(ending, SessionEnding::stopped);
    EXPECT_EQ(study::read_study(file()).trials.size(), 1U);
}

/// From when the question is seen, if the hand held on after the end.
TEST_F(StudySitting, AnErrorOfTheWindowEndsItAsFailed) {
    EXPECT_THROW(run([](MadeUpPort &port, session::Session &) {
                     port.on_frame = [](const ParticipantPicture &, const SittingState &state) {
                         if (state.step == SittingStep::response) {
                             throw InputError("no letters");
                         }
                     };
                 }),
                 InputError);
    EXPECT_EQ(study::StudyStore(file()).contents().sessions.front().ending,
              study::SessionEnding::failed);
}

TEST_F(StudySitting, TheTimeToAnswerBeginsWithTheQuestion) {
    protocol_.timing.response_s = 0.35; // 0.3 s after the question; the hand leaves for longer
    const SessionEnding ending = run();
    EXPECT_EQ(ending, SessionEnding::completed);
    int late = 0;
    for (const Trial &trial : study::read_study(file()).trials) {
        const double time_s = trial.response_time_s.value_or(0.0);
        late += time_s > protocol_.timing.response_s ? 1 : 0;
    }
    EXPECT_GT(late, 0);
    expect_same_decisions(study::read_study(file()).trials, headless());
}

/// A hand that has left the surface goes on upwards; only then, from its rest, to the side.
TEST_F(StudySitting, AGestureIsNoMoreThanWhatFollowsTheLift) {
    protocol_.responses = {study::ResponseDevice::gesture, {"left", "right"}};
    protocol_.timing.response_s = 3.5;
    struct Moves {
        Vector3 lift_m; ///< at once, with the question
        Vector3 then_m; ///< after 1.9 s, from there
        study::Response given;
    };
    const std::vector<Moves> all{{{0.0, 0.05, 0.0}, {0.0, 0.0, 0.0}, study::NoResponse{}},
                                 {{0.03, 0.05, 0.0}, {0.0, 0.0, 0.0}, study::NoResponse{}}, // askew
                                 {{0.03, 0.02, 0.0}, {-0.028, 0.0, 0.0}, study::Chosen{1}},
                                 {{0.0, 0.03, 0.0}, {0.028, 0.03, 0.0}, study::Chosen{2}},
                                 {{0.0, 0.03, 0.0}, {0.012, 0.03, 0.0}, study::NoResponse{}}};
    std::size_t asked = 0;
    run([&](MadeUpPort &port, session::Session &session) {
        port.is_silent = true;
        double since_s = -1.0;
        bool has_moved = false;
        Vector3 from_m = Vector3::Zero();
        port.on_frame = [&, since_s, has_moved, from_m](const ParticipantPicture &,
                                                        const SittingState &state) mutable {
            const double now_s = session.servo().now_s();
            if (state.step == SittingStep::practice_ends) {
                port.inputs = {MadeUpPort::key("enter", now_s)};
            }
            port.orders.stops = asked == all.size() && state.step != SittingStep::response;
            if (state.step != SittingStep::response) {
                since_s = -1.0;
                return;
            }
            if (since_s < 0.0) {
                since_s = now_s;
                has_moved = false;
                from_m = session.latest().tip_m;
                session.follow_path(simulated::HandPath({{0.0, from_m + all.at(asked++).lift_m}}));
            } else if (now_s > since_s + 1.9 && !std::exchange(has_moved, true)) {
                const Moves &moves = all.at(asked - 1);
                session.follow_path(
                    simulated::HandPath({{0.0, from_m + moves.lift_m + moves.then_m}}));
            }
        };
    });
    const std::vector<Trial> trials = study::read_study(file()).trials;
    ASSERT_EQ(trials.size(), all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        EXPECT_EQ(trials[i].response, all[i].given) << i;
    }
}

TEST_F(StudySitting, WarmsColdWindingsBeforeTheFirstTrial) {
    protocol_.windings = {25.0, 26.0, 60.0}; // the air's, then the band
    std::vector<double> left_shares;
    run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
            port.orders.stops = state.trials.size() == 2;
            if (state.step == SittingStep::warming_up) {
                left_shares.push_back(picture.left_share.value());
            }
        };
    });
    ASSERT_FALSE(left_shares.empty()); // a bar that empties, and never fills again
    EXPECT_EQ(left_shares.front(), 1.0);
    EXPECT_LT(left_shares.back(), 0.1);
    EXPECT_TRUE(std::ranges::is_sorted(left_shares, std::ranges::greater{}));
    EXPECT_GT(std::set<double>(left_shares.begin(), left_shares.end()).size(), 10U);
    EXPECT_TRUE(steps_.contains(SittingStep::warming_up));
    const std::vector<Trial> trials = study::read_study(file()).trials;
    ASSERT_EQ(trials.size(), 2U);
    for (const std::optional<double> winding_C : trials.front().windings_degC) {
        EXPECT_GE(winding_C.value(), protocol_.windings.from_C);
    }
}

TEST_F(StudySitting, PractisesAgainUntilItIsUnderstood) {
    int begun = 0;
    int asked_in_practice = 0;
    SittingStep before = SittingStep::over;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
            if (state.step == SittingStep::practice_ends && before != state.step) {
                EXPECT_EQ(picture.text, "Press 1 to practise again, 2 to begin.");
                if (++begun <= 2) { // twice
                    port.inputs = {MadeUpPort::key("1", 0.0)};
                }
            }
            if (state.step == SittingStep::response && before != state.step && begun <= 2 &&
                state.trial->is_practice) {
                ++asked_in_practice;
            }
            before = state.step;
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    EXPECT_GE(begun, 3);
    EXPECT_EQ(asked_in_practice, 3 * protocol_.practice.min_trials);
    const study::StudyContents contents = study::read_study(file());
    expect_same_decisions(contents.trials, headless()); // the sequence knows nothing of it
    ASSERT_EQ(contents.notes.size(), 2U);
    EXPECT_EQ(contents.notes[0].text, "practised 2 trials again, which are not stored");
}

TEST_F(StudySitting, WhoWasStoppedAfterThePracticeIsAskedAgain) {
    run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            port.orders.stops = state.step == SittingStep::practice_ends;
        };
    });
    bool was_asked = false;
    int practised = 0;
    SittingStep before = SittingStep::over;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &, const SittingState &state) {
            if (state.step == SittingStep::practice_ends && !std::exchange(was_asked, true)) {
                port.inputs = {MadeUpPort::key("1", 0.0)};
            }
            if (state.step == SittingStep::response && before != state.step) {
                EXPECT_TRUE(was_asked);
                practised += state.trial->is_practice ? 1 : 0;
            }
            before = state.step;
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    EXPECT_EQ(practised, protocol_.practice.min_trials);
    expect_same_decisions(study::read_study(file()).trials, headless());
}

/// What is practised again is not of the sequence: nothing of it comes again later.
TEST_F(StudySitting, RepeatedPracticeDoesNotSpeakOfComingAgain) {
    bool is_again = false;
    int asked_again = 0;
    SittingStep before = SittingStep::over;
    std::set<std::string> said;
    const auto practise = [&](bool is_silent) {
        is_again = false;
        asked_again = 0;
        said.clear();
        static_cast<void>(run([&](MadeUpPort &port, session::Session &) {
            port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
                if (state.step == SittingStep::practice_ends && before != state.step) {
                    port.orders.stops = std::exchange(is_again, true);
                    port.is_silent = is_silent;
                    port.inputs = {MadeUpPort::key("1", 0.0)};
                }
                if (is_again && state.step == SittingStep::after_response) {
                    said.insert(picture.text + picture.heading);
                }
                asked_again +=
                    is_again && state.step == SittingStep::response && before != state.step ? 1 : 0;
                before = state.step;
            };
        }));
    };
    practise(true);
    EXPECT_EQ(asked_again, protocol_.practice.min_trials);
    EXPECT_TRUE(said.empty());
    practise(false);
    EXPECT_EQ(asked_again, protocol_.practice.min_trials);
    EXPECT_FALSE(said.empty()) << "right or wrong";
}

TEST_F(StudySitting, EachBlockAfterTheFirstIsAnnounced) {
    ASSERT_GT(protocol_.blocks.size(), 1U);
    std::set<int> announced_after; // trials' blocks
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
            if (state.step == SittingStep::block_begins) {
                EXPECT_EQ(picture.text, protocol_.texts.block_begins);
                announced_after.insert(state.trials.back().place.block);
            }
        };
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    EXPECT_EQ(announced_after.size(), protocol_.blocks.size() - 1);
}

TEST_F(StudySitting, AParticipantWhoLeavesIsThankedAndStoredAsThat) {
    Once once(1);
    std::string last;
    const SessionEnding ending = run([&](MadeUpPort &port, session::Session &) {
        port.on_frame = [&](const ParticipantPicture &picture, const SittingState &state) {
            port.orders.participant_leaves = once.is_now(state);
            last = picture.heading;
        };
    });
    EXPECT_EQ(ending, SessionEnding::left);
    EXPECT_EQ(last, protocol_.texts.done_early);
    EXPECT_TRUE(study::read_study(file()).trials.empty());
}

} // namespace
} // namespace springdrive::app::study_screen
