// Covers engine/study/conduct/sequence.cpp.
#include "engine/study/conduct/sequence.h"

#include "base/input_error.h"
#include "tests/engine/study/conduct/small_study.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>

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

TEST(StudySequence, BlocksComeInTheOrderOfTheParticipantsNumber) {
    const Protocol protocol = small_protocol(); // two blocks in both orders
    std::set<std::size_t> first;
    for (const int participant : {1, 2}) {
        std::vector<Trial> stored;
        const std::vector<PlannedTrial> planned = all_planned(protocol, participant, stored);
        const Sequence sequence = sequence_after(protocol, participant, stored);
        first.insert(sequence.ended().front().block);
        EXPECT_NE(sequence.ended().front().block, sequence.ended().back().block);
        for (const PlannedTrial &trial : planned) {
            const int block = sequence.order()[static_cast<std::size_t>(trial.place.block) - 1];
            const auto &own = protocol.blocks[static_cast<std::size_t>(block)].conditions;
            EXPECT_TRUE(std::ranges::any_of(own, [&](std::size_t condition) {
                return protocol.conditions[condition].name == trial.condition;
            }));
        }
    }
    EXPECT_EQ(first.size(), 2U);
}

TEST(StudySequence, EachConditionHasTheTrialsOfItsMethod) {
    const Protocol protocol = small_protocol();
    std::vector<Trial> stored;
    const std::vector<PlannedTrial> planned = all_planned(protocol, 1, stored, 0.2);
    std::map<std::pair<std::string, std::string>, int>
        measured; // by condition and track, without marked
    int practice = 0;
    for (std::size_t i = 0; i < planned.size(); ++i) {
        if (is_measured(planned[i]) && !stored[i].is_presented_again) {
            ++measured[{planned[i].condition, planned[i].track}];
        }
        if (planned[i].is_practice) {
            ++practice;
            EXPECT_EQ(planned[i].place.block, 1); // of the first block only
        }
    }
    EXPECT_EQ(measured.size(), 8U);
    for (const auto &[of, trials] : measured) {
        EXPECT_EQ(trials, 6) << of.first << ' ' << of.second;
    }
    EXPECT_GE(practice, 3);
}

TEST(StudySequence, PlacesAreCountedByBlockAndKeysAreAllDifferent) {
    const Protocol protocol = small_protocol();
    std::vector<Trial> stored;
    const std::vector<PlannedTrial> planned = all_planned(protocol, 1, stored, 0.2);
    std::set<std::uint64_t> keys;
    TrialPlace expected{1, 1, 1};
    for (const PlannedTrial &trial : planned) {
        if (trial.place.block != expected.block) {
            expected = {expected.block + 1, 1, 1};
        }
        EXPECT_EQ(trial.place, expected);
        ++expected.position;
        EXPECT_TRUE(keys.insert(trial.seed).second);
    }
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
        EXPECT_EQ(before->level, planned[i].level);
        EXPECT_EQ(before->condition, planned[i].condition);
        EXPECT_EQ(before->track, planned[i].track);
        EXPECT_EQ(before->is_practice, planned[i].is_practice);
        EXPECT_EQ(before->is_catch, planned[i].is_catch);
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

} // namespace
} // namespace springdrive::study
