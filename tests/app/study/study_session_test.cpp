// Covers app/study/session/{session,interludes,trial_presenter}.cpp: whole sessions, what an
// experimenter may do in them, and that they go on; and what a blind experimenter sees of them, by
// app/study/experimenter/study_window.cpp. See study_window_test.cpp for the real windows.
#include "app/study/experimenter/study_window.h"
#include "engine/study/conduct/conduct.h"
#include "tests/app/study/made_up_people.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace springdrive::app::study_screen {
namespace {

using study::SessionEnding;
using study::Trial;

bool has_answer(const Trial &trial) {
    return !std::holds_alternative<study::NoResponse>(trial.response);
}

/// What the experimenter's view draws: where things are, and the force.
std::vector<Vector3> drawn_of(const ViewState &state) {
    return {state.tip_m,           state.proxy_m,       state.tip_force_N, state.hand_target_m,
            state.linkage.elbow_m, state.linkage.tip_m, state.normal,      state.below->point_m};
}

/// How far apart two of them are, at the most.
double spread_of(const std::vector<std::vector<Vector3>> &all) {
    double most = 0.0;
    for (const std::vector<Vector3> &one : all) {
        for (std::size_t i = 0; i < one.size(); ++i) {
            most = std::max(most, (one[i] - all.front()[i]).norm());
        }
    }
    return most;
}

/// All blocks of a study whose forces turn by 20 and 60 degrees to either side.
TEST_F(StudySessionTest, StoresWhatTheSameDecisionsGiveHeadlessAndHidesThemFromTheExperimenter) {
    protocol_ = short_protocol("direction");
    ASSERT_GT(protocol_.blocks.size(), 1U);
    protocol_.timing.response_s = 0.35; // 0.3 s after the question; the hand leaves for longer
    const study::StudySetting setting = study::study_setting(protocol_, folders_);
    std::set<int> announced_after; // trials' blocks
    std::vector<std::vector<Vector3>> blind;
    std::vector<std::vector<Vector3>> seeing;
    double blind_force_N = 0.0;
    const SessionEnding ending = run([&](const Moment &now) {
        if (now.state.step == StudySessionStep::block_begins) {
            EXPECT_EQ(now.picture.text, protocol_.texts.block_begins);
            announced_after.insert(now.state.trials.back().place.block);
        }
        const servo::ServoSample &sample = now.session.latest();
        const auto view = [&](const std::optional<Vector3> &hidden_at) {
            return experimenter_view(sample, now.session.description(),
                                     now.session.scenes().now().surface, hidden_at);
        };
        const Vector3 at_m =
            now.state.trial
                ? setting.conditions[study::condition_of(protocol_, *now.state.trial)].spot.point_m
                : sample.tip_m;
        blind_force_N = std::max(blind_force_N, view(at_m).tip_force_N.norm());
        if (sample.contact.touching && now.state.step == StudySessionStep::interval) {
            blind.push_back(drawn_of(view(at_m)));
            seeing.push_back(drawn_of(view(std::nullopt)));
        }
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    for (const StudySessionStep step :
         {StudySessionStep::instructions, StudySessionStep::practice_begins,
          StudySessionStep::practice_ends, StudySessionStep::in_break, StudySessionStep::interval,
          StudySessionStep::response, StudySessionStep::over}) {
        EXPECT_TRUE(steps_.contains(step)) << description(step);
    }
    EXPECT_EQ(announced_after.size(), protocol_.blocks.size() - 1);
    const std::vector<Trial> trials = contents().trials;
    expect_same_decisions(trials, headless());
    int late = 0; // the time to answer begins with the question
    for (const Trial &trial : trials) {
        ASSERT_EQ(trial.presentations.size(), 2U);
        if (trial.response_time_s) {
            // The question comes when the hand has left, at most half a second after the end.
            EXPECT_GE(*trial.response_time_s, 0.3);
            EXPECT_LE(*trial.response_time_s, 1.0);
            late += *trial.response_time_s > protocol_.timing.response_s ? 1 : 0;
        }
    }
    EXPECT_GT(late, 0);
    ASSERT_GT(blind.size(), 100U);
    EXPECT_EQ(spread_of(blind), 0.0);
    EXPECT_EQ(blind_force_N, 0.0);
    EXPECT_GT(spread_of(seeing), 0.1) << "of forces, in N: there is something to hide";
}

TEST_F(StudySessionTest, GoesOnAfterAStopAsIfUndisturbed) {
    for (const int position : {2, 3}) {
        Once once(position);
        EXPECT_EQ(run([&](const Moment &now) { now.port.orders.stops = once.is_now(now.state); }),
                  SessionEnding::stopped);
    }
    EXPECT_EQ(run(), SessionEnding::completed);
    EXPECT_EQ(contents().sessions.size(), 3U);
    expect_same_decisions(contents().trials, headless());
}

TEST_F(StudySessionTest, PausesBreaksAndRepeatsAsTheExperimenterWants) {
    Once pauses(2);
    Once repeats(4);
    Once breaks(5);
    int paused = 0;
    int in_break = 0;
    bool counts_break = false;
    run([&](const Moment &now) {
        ExperimenterOrders &orders = now.port.orders;
        orders.is_paused = orders.is_paused || pauses.is_now(now.state);
        if (now.state.step == StudySessionStep::paused && ++paused == 120) {
            orders.is_paused = false;
        }
        orders.repeats = orders.repeats || repeats.is_now(now.state);
        if (breaks.is_now(now.state)) {
            orders.skips_to_break = counts_break = true;
        }
        in_break += counts_break && now.state.step == StudySessionStep::in_break ? 1 : 0;
        orders.stops = now.state.trial && now.state.trial->place.position == 6;
    });
    EXPECT_EQ(paused, 120);
    EXPECT_GE(in_break, 59); // a second
    const std::vector<Trial> trials = contents().trials;
    const auto repeated = std::ranges::find_if(trials, [](const Trial &trial) {
        return std::ranges::count(trial.marks, "repeated at the experimenter's wish") > 0;
    });
    ASSERT_NE(repeated, trials.end());
    EXPECT_EQ(repeated->place.position, 4);
    EXPECT_TRUE(repeated->is_presented_again);
}

/// Every trial is marked, and none repeated but without an answer, or at the experimenter's wish.
TEST_F(StudySessionTest, SaysThatATrialComesAgainIfItDoes) {
    protocol_ = short_protocol("direction");
    protocol_.marking.repeats = false;
    protocol_.marking.direction_deg = 1e-9;
    protocol_.marking.max_marked = 100;
    std::set<study::TrialPlace> announced;
    std::set<study::TrialPlace> requested;
    const SessionEnding ending = run([&](const Moment &now) {
        if (now.state.step == StudySessionStep::after_response &&
            now.picture.text == protocol_.texts.repeated) {
            announced.insert(now.state.trial->place);
        }
        if (now.state.step == StudySessionStep::response &&
            now.state.trial->place.position % 3 == 0 && now.state.trial->place.attempt == 1) {
            now.port.orders.repeats = true;
            requested.insert(now.state.trial->place);
        }
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    int once_only = 0;
    int answered_and_wanted = 0;
    for (const Trial &trial : contents().trials) {
        EXPECT_FALSE(trial.marks.empty());
        EXPECT_EQ(announced.contains(trial.place), !has_answer(trial)) << text_of(trial.place);
        EXPECT_EQ(trial.is_presented_again, !has_answer(trial) || requested.contains(trial.place));
        once_only += trial.is_presented_again ? 0 : 1;
        answered_and_wanted += has_answer(trial) && requested.contains(trial.place) ? 1 : 0;
    }
    EXPECT_FALSE(announced.empty());
    EXPECT_GT(once_only, 0);
    EXPECT_GT(answered_and_wanted, 0);
}

/// As the included protocol warms them, for a minute and a half: R̂ must follow the heat of a
/// current whose mean is zero, or dR and stiffness are others than intended. A pause that is wanted
/// meanwhile begins when the hand is off.
TEST_F(StudySessionTest, PresentsWhatIsIntendedAfterAWarmUp) {
    protocol_.windings =
        study::read_protocol_file(testing::assets() / "protocols/direction.toml").windings;
    constexpr int kPaused = 100; ///< frames
    std::vector<double> left_shares;
    int paused = 0;
    run([&](const Moment &now) {
        if (now.state.step == StudySessionStep::warming_up && paused == 0) {
            left_shares.push_back(now.picture.left_share.value());
        }
        paused += now.state.step == StudySessionStep::paused ? 1 : 0;
        now.port.orders.is_paused = (now.state.step == StudySessionStep::warming_up ||
                                     now.state.step == StudySessionStep::paused) &&
                                    paused < kPaused;
        EXPECT_TRUE(now.state.step != StudySessionStep::interval || paused == kPaused);
        now.port.orders.stops = now.state.trials.size() == 4;
    });
    EXPECT_EQ(paused, kPaused);
    ASSERT_GT(left_shares.size(), 60U * 60U); // a bar that empties, and never fills again
    EXPECT_EQ(left_shares.front(), 1.0);
    EXPECT_LT(left_shares.back(), 0.1);
    EXPECT_TRUE(std::ranges::is_sorted(left_shares, std::ranges::greater{}));
    EXPECT_GT(std::set<double>(left_shares.begin(), left_shares.end()).size(), 10U);
    const std::vector<Trial> trials = contents().trials;
    ASSERT_EQ(trials.size(), 4U);
    for (const std::optional<double> winding_C : trials.front().windings_degC) {
        EXPECT_GE(winding_C.value(), protocol_.windings.from_C);
    }
    for (const Trial &trial : trials) {
        EXPECT_EQ(trial.marks.empty(), has_answer(trial)) << trial.marks.front();
        for (const study::Presentation &presentation : trial.presentations) {
            const auto stiffness = std::ranges::find(presentation.values, "stiffness_N_per_m",
                                                     &study::StimulusValue::name);
            ASSERT_NE(stiffness, presentation.values.end());
            EXPECT_NEAR(*stiffness->delivered / *stiffness->intended, 1.0,
                        0.01 * protocol_.marking.stiffness_percent);
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
        for (const int away_mm : {0, 1, 2, 4, 5, 10, 15, 20}) { // all remainders by 7
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

TEST_F(StudySessionTest, AnswersAreStoredWhateverEndsTheSessionInTheFeedback) {
    const SessionEnding ending = run([](const Moment &now) {
        now.port.orders.stops = now.state.step == StudySessionStep::after_response &&
                                (!now.picture.heading.empty() || !now.picture.text.empty());
    });
    EXPECT_EQ(ending, SessionEnding::stopped);
    EXPECT_EQ(contents().trials.size(), 1U);
}

TEST_F(StudySessionTest, AParticipantWhoLeavesIsThankedAndStoredAsThat) {
    Once once(1);
    std::string last;
    const SessionEnding ending = run([&](const Moment &now) {
        now.port.orders.participant_leaves = once.is_now(now.state);
        last = now.picture.heading;
    });
    EXPECT_EQ(ending, SessionEnding::left);
    EXPECT_EQ(last, protocol_.texts.done_early);
    EXPECT_TRUE(contents().trials.empty());
}

TEST_F(StudySessionTest, AnErrorOfTheWindowEndsItAsFailed) {
    EXPECT_THROW(run([](const Moment &now) {
                     if (now.state.step == StudySessionStep::response) {
                         throw InputError("no letters");
                     }
                 }),
                 InputError);
    EXPECT_EQ(study::StudyStore(file()).contents().sessions.front().ending, SessionEnding::failed);
}

/// A hand that has left the surface goes on upwards; only then, from its rest, to the side.
TEST_F(StudySessionTest, AGestureIsNoMoreThanWhatFollowsTheLift) {
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
    double since_s = 0.0;
    bool has_moved = false;
    Vector3 from_m = Vector3::Zero();
    run([&](const Moment &now) {
        const double now_s = now.session.servo().now_s();
        now.port.is_silent = true;
        if (now.state.step == StudySessionStep::practice_ends) {
            now.port.inputs = {MadeUpPort::key("enter", now_s)};
        }
        now.port.orders.stops = asked == all.size() && now.state.step != StudySessionStep::response;
        if (now.state.step != StudySessionStep::response) {
            return;
        }
        if (now.is_new_step) {
            since_s = now_s;
            has_moved = false;
            from_m = now.session.latest().tip_m;
            now.session.follow_path(simulated::HandPath({{0.0, from_m + all.at(asked++).lift_m}}));
        } else if (now_s > since_s + 1.9 && !std::exchange(has_moved, true)) {
            const Moves &moves = all.at(asked - 1);
            now.session.follow_path(
                simulated::HandPath({{0.0, from_m + moves.lift_m + moves.then_m}}));
        }
    });
    const std::vector<Trial> trials = contents().trials;
    ASSERT_EQ(trials.size(), all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        EXPECT_EQ(trials[i].response, all[i].given) << i;
    }
}

/// Who was stopped after the practice is asked again. What is practised again is not of the
/// sequence: nothing of it comes again later, so that nobody is told so.
TEST_F(StudySessionTest, PractisesAgainUntilItIsUnderstood) {
    run([](const Moment &now) {
        now.port.orders.stops = now.state.step == StudySessionStep::practice_ends;
    });
    int asked = 0;
    std::vector<int> practised(4); // trials after it was asked for the nth time
    std::vector<std::set<std::string>> said(4);
    const SessionEnding ending = run([&](const Moment &now) {
        const auto after = static_cast<std::size_t>(asked);
        if (now.state.step == StudySessionStep::practice_ends && now.is_new_step) {
            EXPECT_EQ(now.picture.text, "Press 1 to practise again, 2 to begin.");
            if (++asked <= 2) { // twice, the first time without an answer
                now.port.inputs = {MadeUpPort::key("1", 0.0)};
            }
            now.port.is_silent = asked == 1;
        } else if (now.state.step == StudySessionStep::response && now.is_new_step &&
                   now.state.trial->is_practice) {
            ++practised.at(after);
        } else if (now.state.step == StudySessionStep::after_response) {
            said.at(after).insert(now.picture.text + now.picture.heading);
        }
    });
    EXPECT_EQ(ending, SessionEnding::completed);
    const int again = protocol_.practice.min_trials;
    EXPECT_EQ(practised, (std::vector<int>{0, again, again, 0}));
    said[2].erase("");
    EXPECT_TRUE(said[1].empty());
    EXPECT_FALSE(said[2].empty()) << "right or wrong";
    const study::StudyContents stored = contents();
    expect_same_decisions(stored.trials, headless());
    ASSERT_EQ(stored.notes.size(), 2U);
    EXPECT_EQ(stored.notes[0].text, "practised 2 trials again, which are not stored");
}

} // namespace
} // namespace springdrive::app::study_screen
