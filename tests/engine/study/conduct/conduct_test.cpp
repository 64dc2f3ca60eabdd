// Covers engine/study/conduct/conduct.cpp: sessions in real study files.
#include "engine/study/conduct/conduct.h"

#include "base/input_error.h"
#include "engine/study/store/database.h"
#include "tests/engine/study/conduct/small_study.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace springdrive::study {
namespace {

namespace fs = std::filesystem;

/// Answers as `answer_to` says, at a time that is a function of the trial.
Conduct plain_conduct(const Protocol &protocol, UtcTime &now) {
    Conduct how;
    how.present = [&protocol, &now](const PlannedTrial &planned) {
        now = test_time(planned.place.block * 1000 + planned.place.position);
        return answer_to(protocol, planned);
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

TEST_F(StudyConduct, GoesOnAfterAnEndAtAnyTrialAsIfThereHadBeenNone) {
    const std::vector<Trial> expected = undisturbed("P02");
    for (std::size_t last = 0; last <= expected.size(); last += 7) {
        const fs::path file = new_study("stopped-" + std::to_string(last));
        std::size_t presented = 0;
        Conduct stops = plain_conduct(protocol_, now_);
        stops.ends = [&presented, last]() -> std::optional<SessionEnding> {
            return presented++ == last ? std::optional(SessionEnding::left) : std::nullopt;
        };
        {
            StudyStore store = quick_store(file);
            const SessionEnding ending = run(store, "P02", stops);
            EXPECT_EQ(ending,
                      last < expected.size() ? SessionEnding::left : SessionEnding::completed);
            EXPECT_EQ(store.contents().trials.size(), std::min(last, expected.size()));
            EXPECT_EQ(store.contents().sessions.back().ending, ending);
        }
        StudyStore store = quick_store(file);
        EXPECT_EQ(run(store, "P02", plain_conduct(protocol_, now_)), SessionEnding::completed);
        expect_same_trials(store.contents().trials, expected);
    }
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
        Conduct dies = plain_conduct(protocol_, now_);
        dies.present = [this, &presented, last](const PlannedTrial &planned) {
            if (presented++ == last) {
                throw Killed("");
            }
            now_ = test_time(planned.place.block * 1000 + planned.place.position);
            return answer_to(protocol_, planned);
        };
        {
            StudyStore store = quick_store(file);
            EXPECT_THROW(run(store, "P01", dies), Killed);
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
    Conduct loses = plain_conduct(protocol_, now_);
    loses.present = [this, &presented](const PlannedTrial &planned) -> std::optional<Trial> {
        if (++presented == 5) {
            return std::nullopt;
        }
        now_ = test_time(planned.place.block * 1000 + planned.place.position);
        return answer_to(protocol_, planned);
    };
    EXPECT_EQ(run(store, "P01", loses), SessionEnding::device_lost);
    EXPECT_EQ(store.contents().trials.size(), 4U);
    EXPECT_EQ(run(store, "P01", loses), SessionEnding::completed);
    expect_same_trials(store.contents().trials, expected);
}

TEST_F(StudyConduct, EndsByTripsAndByTimeJustBeyondTheProtocolsLimits) {
    protocol_.stopping.max_trips = 2;
    Conduct trips = plain_conduct(protocol_, now_);
    trips.present = [this](const PlannedTrial &planned) {
        Trial result = answer_to(protocol_, planned);
        result.safety_events = {{std::nullopt, "a trip"}};
        return result;
    };
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
    Conduct how = plain_conduct(protocol_, now_);
    how.present = [this](const PlannedTrial &planned) {
        now_ = test_time(planned.place.block * 1000 + planned.place.position);
        Trial result = answer_to(protocol_, planned);
        result.is_presented_again = planned.place.position == 5 && planned.place.attempt == 1;
        if (result.is_presented_again) {
            result.marks.emplace_back("wanted again");
        }
        return result;
    };
    StudyStore store = quick_store(new_study("wanted"));
    EXPECT_EQ(run(store, "P01", how), SessionEnding::completed);
    int wanted = 0;
    for (const Trial &trial : store.contents().trials) {
        const bool is_wanted = trial.place.position == 5 && trial.place.attempt == 1;
        const bool has_answer = !std::holds_alternative<NoResponse>(trial.response);
        EXPECT_EQ(trial.is_presented_again, is_wanted || !has_answer);
        wanted += is_wanted && has_answer ? 1 : 0;
    }
    EXPECT_GT(wanted, 0);
}

TEST_F(StudyConduct, RefusesToGoOnWithAnotherProtocol) {
    const fs::path file = new_study("other");
    StudyStore store = quick_store(file);
    int presented = 0;
    Conduct stops = plain_conduct(protocol_, now_);
    stops.ends = [&presented]() -> std::optional<SessionEnding> {
        return presented++ == 3 ? std::optional(SessionEnding::stopped) : std::nullopt;
    };
    EXPECT_EQ(run(store, "P01", stops), SessionEnding::stopped);
    ++protocol_.seed;
    const std::vector<Trial> before = store.contents().trials;
    EXPECT_THROW(run(store, "P01", plain_conduct(protocol_, now_)), InputError);
    EXPECT_EQ(store.contents().trials, before);
    EXPECT_EQ(store.contents().sessions.back().ending, SessionEnding::failed);
}

} // namespace
} // namespace springdrive::study
