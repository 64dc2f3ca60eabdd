// Covers engine/study/conduct: sequences, marks, and sessions in real study files.
#include "base/input_error.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/store/database.h"
#include "tests/engine/study/conduct/small_study.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>

namespace springdrive::study {
namespace {

/// As conduct stores it, as far as the sequence looks at it.
Trial answered(const PlannedTrial &planned, bool marked) {
    Trial trial(planned);
    trial.response = Chosen{
        uniform(child(RandomKey{planned.seed}, 1)) < 0.75 ? *planned.target : 3 - *planned.target};
    trial.is_presented_again = marked;
    return trial;
}

bool is_measured(const PlannedTrial &trial) { return !trial.is_practice && !trial.is_catch; }

std::vector<PlannedTrial> all_planned(const Protocol &protocol, int participant,
                                      std::vector<Trial> &stored, double marked_share = 0.0) {
    Sequence sequence(protocol, participant);
    std::vector<PlannedTrial> planned;
    while (const std::optional<PlannedTrial> trial = sequence.next()) {
        planned.push_back(*trial);
        stored.push_back(
            answered(*trial, uniform(child(RandomKey{trial->seed}, 2)) < marked_share));
        sequence.add(stored.back());
    }
    EXPECT_EQ(sequence.ended().size(), protocol.blocks.size());
    return planned;
}

/// Of two participants, who have two blocks in both orders.
TEST(StudySequence, HasTheBlocksConditionsAndPlacesOfTheProtocol) {
    const Protocol protocol = small_protocol();
    std::set<std::size_t> first;
    for (const int participant : {1, 2}) {
        std::vector<Trial> stored;
        const std::vector<PlannedTrial> planned = all_planned(protocol, participant, stored, 0.2);
        const Sequence sequence = sequence_after(protocol, participant, stored);
        first.insert(sequence.ended().front().block);
        EXPECT_NE(sequence.ended().front().block, sequence.ended().back().block);
        std::map<std::pair<std::string, std::string>, int> measured; // by condition and track
        int practice = 0;
        std::set<std::uint64_t> keys;
        TrialPlace expected{1, 1, 1};
        for (std::size_t i = 0; i < planned.size(); ++i) {
            const PlannedTrial &trial = planned[i];
            const int block = sequence.order()[static_cast<std::size_t>(trial.place.block) - 1];
            const auto &own = protocol.blocks[static_cast<std::size_t>(block)].conditions;
            EXPECT_TRUE(std::ranges::any_of(own, [&](std::size_t condition) {
                return protocol.conditions[condition].name == trial.condition;
            }));
            if (trial.place.block != expected.block) {
                expected = {expected.block + 1, 1, 1};
            }
            EXPECT_EQ(trial.place, expected);
            ++expected.position;
            EXPECT_TRUE(keys.insert(trial.seed).second);
            if (is_measured(trial) && !stored[i].is_presented_again) {
                ++measured[{trial.condition, trial.track}];
            }
            practice += trial.is_practice ? 1 : 0;
            EXPECT_TRUE(!trial.is_practice || trial.place.block == 1) << "of the first block only";
        }
        EXPECT_EQ(measured.size(), 8U);
        for (const auto &[of, trials] : measured) {
            EXPECT_EQ(trials, 6) << of.first << ' ' << of.second;
        }
        EXPECT_GE(practice, 3);
    }
    EXPECT_EQ(first.size(), 2U);
}

TEST(StudySequence, GoesOnFromAnyTrialAsAnUndisturbedOne) {
    const Protocol protocol = small_protocol();
    std::vector<Trial> stored;
    const std::vector<PlannedTrial> planned = all_planned(protocol, 2, stored, 0.2);
    for (std::size_t i = 0; i < planned.size(); ++i) {
        EXPECT_EQ(sequence_after(protocol, 2, std::span(stored).first(i)).next(), planned[i]) << i;
    }
    EXPECT_FALSE(sequence_after(protocol, 2, stored).next());
}

TEST(StudySequence, AMarkedTrialIsRepeatedLaterAndOnce) {
    const Protocol protocol = small_protocol();
    std::vector<Trial> stored;
    const std::vector<PlannedTrial> planned = all_planned(protocol, 1, stored, 0.3);
    std::map<TrialPlace, int> repetitions;
    for (std::size_t i = 0; i < planned.size(); ++i) {
        if (!planned[i].repetition_of) {
            continue;
        }
        ++repetitions[*planned[i].repetition_of];
        const auto before =
            std::ranges::find(planned, *planned[i].repetition_of, &PlannedTrial::place);
        ASSERT_LT(before, planned.begin() + static_cast<std::ptrdiff_t>(i));
        const auto what = [](const PlannedTrial &one) {
            return std::tuple(one.level, one.condition, one.track, one.is_practice, one.is_catch);
        };
        EXPECT_EQ(what(*before), what(planned[i]));
    }
    int marked_and_measured = 0;
    for (std::size_t i = 0; i < planned.size(); ++i) {
        const bool is_repeated = repetitions.contains(planned[i].place);
        EXPECT_LE(repetitions[planned[i].place], 1);
        EXPECT_FALSE(is_repeated && !stored[i].is_presented_again);
        if (is_measured(planned[i]) && stored[i].is_presented_again) {
            ++marked_and_measured;
            EXPECT_TRUE(is_repeated) << text_of(planned[i].place);
        }
    }
    EXPECT_GT(marked_and_measured, 5);
}

TEST(StudySequence, ABlockWithTooManyMarkedTrialsEndsUnfinished) {
    Protocol protocol = small_protocol();
    protocol.marking.max_marked = 2;
    Sequence sequence(protocol, 1);
    for (int i = 0; i < 3; ++i) {
        ASSERT_TRUE(sequence.ended().empty());
        sequence.add(answered(*sequence.next(), true));
    }
    ASSERT_EQ(sequence.ended().size(), 1U);
    EXPECT_EQ(sequence.ended()[0].state, BlockState::too_many_marked);
    EXPECT_EQ(sequence.next()->place, (TrialPlace{2, 1, 1}));
}

TEST(StudySequence, RefusesWhatItDidNotAskFor) {
    const Protocol protocol = small_protocol();
    const PlannedTrial planned = *Sequence(protocol, 1).next();
    const Trial right = answered(planned, false);
    EXPECT_NO_THROW(Sequence(protocol, 1).add(right));
    const auto refuses = [&protocol](Trial wrong) {
        wrong.participant = "P01";
        Sequence sequence(protocol, 1);
        EXPECT_THROW(sequence.add(wrong), InputError);
        EXPECT_EQ(*sequence.next(), *Sequence(protocol, 1).next()); // and is as before
    };
    for (const auto &change : std::vector<std::function<void(Trial &)>>{
             [](Trial &trial) { trial.place.position = 2; },
             [](Trial &trial) { trial.condition = "none"; },
             [](Trial &trial) { trial.track = "9"; },
             [](Trial &trial) { trial.is_practice = !trial.is_practice; },
             [](Trial &trial) { trial.is_catch = !trial.is_catch; },
             [](Trial &trial) { ++trial.seed; }, [](Trial &trial) { trial.level_name = "eta"; },
             [](Trial &trial) { *trial.level += 1e-12; },
             [](Trial &trial) { trial.target = 3 - *trial.target; },
             [](Trial &trial) { trial.repetition_of = TrialPlace{}; }}) {
        Trial wrong = right;
        change(wrong);
        refuses(wrong);
    }
    Protocol other = protocol;
    other.seed = 8;
    EXPECT_THROW(Sequence(other, 1).add(right), InputError);
}

TEST(StoredTrials, SayWhatTheLevelIsAndWhichAnswerIsRight) {
    Protocol protocol = small_protocol();
    EXPECT_EQ(level_name_of(protocol), "eta_added");
    protocol.variable.level = LevelMeaning::taken_off;
    EXPECT_EQ(level_name_of(protocol), "eta_taken_off");
    protocol.variable.level = LevelMeaning::value;
    EXPECT_EQ(level_name_of(protocol), "eta");

    Trial trial;
    trial.target = 2;
    EXPECT_EQ(is_correct(protocol.task, trial), std::nullopt); // no response
    trial.response = Chosen{2};
    EXPECT_EQ(is_correct(protocol.task, trial), true);
    EXPECT_TRUE(outcome_of(protocol, trial).positive);
    trial.response = Chosen{1};
    EXPECT_EQ(is_correct(protocol.task, trial), false);
    EXPECT_FALSE(outcome_of(protocol, trial).positive);

    protocol.task.kind = TaskKind::yes_no;
    trial.target = std::nullopt;
    trial.response = YesNo{true};
    EXPECT_EQ(is_correct(protocol.task, trial), std::nullopt);
    EXPECT_TRUE(outcome_of(protocol, trial).positive);
    trial.response = Adjusted{0.25};
    EXPECT_EQ(outcome_of(protocol, trial).setting, 0.25);
}

std::vector<std::string> marks(const char *name, std::optional<double> intended,
                               std::optional<double> delivered) {
    Presentation shown;
    shown.values = {{name, intended, delivered}};
    return marks_of(Marking{}, std::vector{shown});
}

TEST(StudyMarks, ABandHasTwoSides) {
    // The defaults: 2 %, 1°, 20 %, 5 ms. Values next to each end of a band, within a thousandth.
    const auto expect_band = [](const char *name, double intended, double low, double high) {
        const double step = 1e-3 * (high - low);
        EXPECT_TRUE(marks(name, intended, low + step).empty()) << name;
        EXPECT_TRUE(marks(name, intended, high - step).empty()) << name;
        EXPECT_EQ(marks(name, intended, low - step).size(), 1U) << name;
        EXPECT_EQ(marks(name, intended, high + step).size(), 1U) << name;
    };
    expect_band("stiffness_N_per_m", 1500.0, 1470.0, 1530.0);
    expect_band("direction_deg", 20.0, 19.0, 21.0);
    expect_band("direction_deg", 0.0, -1.0, 1.0);
    expect_band("press_N", 1.0, 0.8, 1.2);
    expect_band("pulse_N", 2.0, 1.6, 2.4);
    expect_band("speed_m_per_s", 0.3, 0.24, 0.36);
    EXPECT_TRUE(marks("lateness_s", 0.0, 0.0049).empty());
    EXPECT_EQ(marks("lateness_s", 0.0, 0.0051).size(), 1U);
}

TEST(StudyMarks, SayWhichValueAndByHowMuch) {
    Presentation good;
    good.values = {{"stiffness_N_per_m", 1000.0, 1000.0}};
    Presentation bad;
    bad.values = {{"stiffness_N_per_m", 1000.0, 1031.0}, {"direction_deg", 10.0, 12.5}};
    const std::vector<std::string> said = marks_of(Marking{}, std::vector{good, bad});
    ASSERT_EQ(said.size(), 2U);
    EXPECT_EQ(said[0].find("stiffness_N_per_m of presentation 2: 3.1 %"), 0U) << said[0];
    EXPECT_EQ(said[1].find("direction_deg of presentation 2: 2.5°"), 0U) << said[1];
}

TEST(StudyMarks, WhatWasIntendedMustBeMeasuredAndOtherNamesHaveNoBand) {
    EXPECT_EQ(marks("stiffness_N_per_m", 1000.0, std::nullopt).size(), 1U);
    EXPECT_TRUE(marks("stiffness_N_per_m", std::nullopt, 1000.0).empty());
    EXPECT_TRUE(marks("peak_force_N", 1.0, 5.0).empty());
    // A NaN is no measurement that lies in a band.
    EXPECT_EQ(marks("stiffness_N_per_m", 1000.0, std::nan("")).size(), 1U);
}

namespace fs = std::filesystem;

/// Answers as `answer_to` says, at a time that is a function of the trial, after a change.
Conduct plain_conduct(const Protocol &protocol, UtcTime &now,
                      const std::function<void(std::optional<Trial> &)> &change = {}) {
    Conduct how;
    how.present = [&protocol, &now, change](const PlannedTrial &planned) {
        now = test_time(planned.place.block * 1000 + planned.place.position);
        std::optional<Trial> trial = answer_to(protocol, planned);
        if (change) {
            change(trial);
        }
        return trial;
    };
    how.ends = [] { return std::nullopt; };
    how.now = [&now] { return now; };
    return how;
}

/// What survives a loss of power is for the tests of the store; without waiting for the disk these
/// here take a second.
StudyStore quick_store(const fs::path &file) {
    DatabaseSettings settings;
    settings.synchronous = "OFF";
    return {file, settings};
}

class StudyConduct : public ::testing::Test {
protected:
    StudyConduct() : folder_(testing::fresh_folder("conduct")) {}

    fs::path new_study(const std::string &name) {
        create_small_study(folder_ / name, protocol_);
        return folder_ / name;
    }

    /// A whole session, undisturbed.
    std::vector<Trial> undisturbed(const std::string &code) {
        StudyStore store = quick_store(new_study("undisturbed-" + code));
        EXPECT_EQ(run(store, code, plain_conduct(protocol_, now_)), SessionEnding::completed);
        return store.contents().trials;
    }

    SessionEnding run(StudyStore &store, const std::string &code, const Conduct &how) {
        const SessionId id = begin_session(store, code);
        return conduct(store, protocol_, session_in(store, id), how);
    }

    Protocol protocol_ = small_protocol();
    UtcTime now_{};

private:
    fs::path folder_;
};

/// Apart from the number of its session, which another session has.
void expect_same_trials(std::vector<Trial> one, std::vector<Trial> other) {
    ASSERT_EQ(one.size(), other.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
        one[i].session = other[i].session = 0;
        EXPECT_EQ(one[i], other[i]) << text_of(one[i].place);
    }
}

TEST_F(StudyConduct, StoresEachTrialWithWhatWasPlannedAndWhatCameOfIt) {
    const std::vector<Trial> trials = undisturbed("P01");
    Sequence sequence(protocol_, 1);
    int again = 0;
    for (const Trial &trial : trials) {
        const PlannedTrial planned = *sequence.next();
        const Trial result = answer_to(protocol_, planned);
        EXPECT_EQ(planned, trial);
        EXPECT_EQ(trial.presentations, result.presentations);
        EXPECT_EQ(trial.response, result.response);
        EXPECT_EQ(trial.tuning, result.tuning);
        EXPECT_EQ(trial.windings_degC, result.windings_degC);
        EXPECT_EQ(trial.software, "0.1.0");
        const bool is_off = result.presentations[0].values[0].delivered > 1020.0;
        const bool is_silent = std::holds_alternative<NoResponse>(result.response);
        EXPECT_EQ(trial.marks.size(), (is_off ? result.presentations.size() : 0U) +
                                          result.safety_events.size() + (is_silent ? 1U : 0U));
        EXPECT_EQ(trial.is_presented_again, !trial.marks.empty());
        again += trial.is_presented_again ? 1 : 0;
        sequence.add(trial);
    }
    EXPECT_FALSE(sequence.next());
    EXPECT_GT(again, 3);
}

/// The program ends in the midst of a trial, or between the commit and the next one.
TEST_F(StudyConduct, GoesOnAfterItWasKilledAtAnyMoment) {
    struct Killed : std::runtime_error {
        using std::runtime_error::runtime_error;
    };
    const std::vector<Trial> expected = undisturbed("P01");
    for (std::size_t last = 1; last < expected.size(); last += 11) {
        const fs::path file = new_study("killed-" + std::to_string(last));
        std::size_t presented = 0;
        const auto dies = [&presented, last](std::optional<Trial> &) {
            if (presented++ == last) {
                throw Killed("");
            }
        };
        {
            StudyStore store = quick_store(file);
            EXPECT_THROW(run(store, "P01", plain_conduct(protocol_, now_, dies)), Killed);
        }
        StudyStore store = quick_store(file);
        EXPECT_EQ(store.contents().sessions.back().ending, SessionEnding::interrupted);
        EXPECT_EQ(run(store, "P01", plain_conduct(protocol_, now_)), SessionEnding::completed);
        expect_same_trials(store.contents().trials, expected);
    }
}

TEST_F(StudyConduct, ALostDeviceEndsTheSessionAndItsTrialComesAgain) {
    const std::vector<Trial> expected = undisturbed("P01");
    const fs::path file = new_study("lost");
    StudyStore store = quick_store(file);
    int presented = 0;
    const Conduct loses = plain_conduct(protocol_, now_, [&presented](std::optional<Trial> &trial) {
        if (++presented == 5) {
            trial.reset();
        }
    });
    EXPECT_EQ(run(store, "P01", loses), SessionEnding::device_lost);
    EXPECT_EQ(store.contents().trials.size(), 4U);
    EXPECT_EQ(run(store, "P01", loses), SessionEnding::completed);
    expect_same_trials(store.contents().trials, expected);
}

TEST_F(StudyConduct, EndsByTripsAndByTimeJustBeyondTheProtocolsLimits) {
    protocol_.stopping.max_trips = 2;
    const Conduct trips = plain_conduct(protocol_, now_, [](std::optional<Trial> &trial) {
        trial->safety_events = {{std::nullopt, "a trip"}};
    });
    StudyStore tripping = quick_store(new_study("trips"));
    EXPECT_EQ(run(tripping, "P01", trips), SessionEnding::safety_trip);
    EXPECT_EQ(tripping.contents().trials.size(), 3U);

    // If too many are marked with the same trial, and the last block ends, nothing is left to end.
    protocol_.blocks = {{"only", {0, 1}}};
    protocol_.practice = {};
    for (const int max_marked : {2, 3}) {
        protocol_.marking.max_marked = max_marked;
        StudyStore ended = quick_store(new_study("trips_and_marks_" + std::to_string(max_marked)));
        EXPECT_EQ(run(ended, "P01", trips),
                  max_marked == 2 ? SessionEnding::completed : SessionEnding::safety_trip);
        EXPECT_EQ(ended.contents().trials.size(), 3U);
    }

    protocol_ = small_protocol();
    protocol_.stopping.longest_session_min = 1.0; // from test_time(0)
    int second = 50;
    Conduct slow = plain_conduct(protocol_, now_);
    slow.now = [&second] { return test_time(second += 5); }; // once a trial, and at the end
    StudyStore late = quick_store(new_study("late"));
    EXPECT_EQ(run(late, "P01", slow), SessionEnding::stopped);
    EXPECT_EQ(late.contents().trials.size(), 3U); // 55, 60, 65 s
}

TEST_F(StudyConduct, WithoutRepeatingOnlyAMissingAnswerIsAskedForAgain) {
    protocol_.marking.repeats = false;
    int silent = 0;
    int marked = 0;
    for (const Trial &trial : undisturbed("P01")) {
        const bool has_answer = !std::holds_alternative<NoResponse>(trial.response);
        EXPECT_EQ(trial.is_presented_again, !has_answer);
        silent += has_answer ? 0 : 1;
        marked += has_answer && !trial.marks.empty() ? 1 : 0;
    }
    EXPECT_GT(silent, 0);
    EXPECT_GT(marked, 0);
}

TEST_F(StudyConduct, WhatTheExperimenterWantsAgainIsRepeatedEvenThen) {
    protocol_.marking.repeats = false;
    const auto want = [](std::optional<Trial> &trial) {
        trial->is_presented_again = trial->place.position == 5 && trial->place.attempt == 1;
        if (trial->is_presented_again) {
            trial->marks.emplace_back("wanted again");
        }
    };
    StudyStore store = quick_store(new_study("wanted"));
    EXPECT_EQ(run(store, "P01", plain_conduct(protocol_, now_, want)), SessionEnding::completed);
    int requested = 0;
    for (const Trial &trial : store.contents().trials) {
        const bool is_requested = trial.place.position == 5 && trial.place.attempt == 1;
        const bool has_answer = !std::holds_alternative<NoResponse>(trial.response);
        EXPECT_EQ(trial.is_presented_again, is_requested || !has_answer);
        requested += is_requested && has_answer ? 1 : 0;
    }
    EXPECT_GT(requested, 0);
}

TEST_F(StudyConduct, EndsWhereItIsToldAndRefusesToGoOnWithAnotherProtocol) {
    const std::vector<Trial> expected = undisturbed("P01");
    std::size_t requested = 0;
    const auto stops_after = [this, &requested](std::size_t trials) {
        requested = 0;
        Conduct stops = plain_conduct(protocol_, now_);
        stops.ends = [&requested, trials]() -> std::optional<SessionEnding> {
            return requested++ == trials ? std::optional(SessionEnding::stopped) : std::nullopt;
        };
        return stops;
    };
    const fs::path file = new_study("stopped");
    {
        StudyStore stopped = quick_store(file);
        EXPECT_EQ(run(stopped, "P01", stops_after(3)), SessionEnding::stopped);
        EXPECT_EQ(stopped.contents().trials.size(), 3U) << "asked before each trial";
        EXPECT_EQ(stopped.contents().sessions.back().ending, SessionEnding::stopped);
    }
    const fs::path copy = file.parent_path() / "goes_on";
    fs::copy_file(file, copy);
    StudyStore goes_on = quick_store(copy);
    EXPECT_EQ(run(goes_on, "P01", plain_conduct(protocol_, now_)), SessionEnding::completed);
    expect_same_trials(goes_on.contents().trials, expected);
    // After the last trial nothing is left to end.
    StudyStore whole = quick_store(new_study("whole"));
    EXPECT_EQ(run(whole, "P01", stops_after(expected.size())), SessionEnding::completed);
    EXPECT_EQ(whole.contents().trials.size(), expected.size());

    StudyStore store = quick_store(file);
    ++protocol_.seed;
    const std::vector<Trial> before = store.contents().trials;
    EXPECT_THROW(run(store, "P01", plain_conduct(protocol_, now_)), InputError);
    EXPECT_EQ(store.contents().trials, before);
    EXPECT_EQ(store.contents().sessions.back().ending, SessionEnding::failed);
}

} // namespace
} // namespace springdrive::study
