// Covers engine/study/methods/block.cpp.
#include "engine/study/methods/block.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

namespace springdrive::study {
namespace {

constexpr RandomKey kBlockKey{4711};

/// Two series of constant stimuli and one of staircases, with everything between them.
Block mixed_block() {
    Staircases staircases;
    staircases.maximum_level = 10.0;
    staircases.start_levels = {8.0, 1.0};
    staircases.steps = {{0, 1.0}};
    staircases.trials = 25;
    staircases.reversals = 0;
    Block block;
    block.task = {TaskKind::forced_choice_by_place, 4, 0.5};
    block.series = {ConstantStimuli{{1.0, 2.0, 3.0}, 1, 20}, staircases,
                    ConstantStimuli{{4.0, 5.0}, 1, 30}};
    block.practice = {{9.0, 10.0}, 6, 3, 20};
    block.catch_trials = {{10.0}, 8};
    block.max_marked = 1000;
    return block;
}

Outcome block_answer(std::size_t number, double marked_share = 0.15) {
    const RandomKey key = child({6}, number);
    return {uniform(child(key, 0)) < 0.7, 0.0, uniform(child(key, 1)) < marked_share};
}

std::vector<PastBlockTrial> whole_run(const Block &block, double marked_share = 0.15) {
    BlockRun run(block, kBlockKey);
    std::vector<PastBlockTrial> past;
    while (const std::optional<BlockTrial> trial = run.next()) {
        past.push_back({*trial, block_answer(past.size(), marked_share)});
        run.add(past.back());
    }
    return past;
}

TEST(Blocks, ResumedAtAnyTrialGoOnAsAnUndisturbedRun) {
    const Block block = mixed_block();
    const std::vector<PastBlockTrial> past = whole_run(block);
    for (std::size_t i = 0; i <= past.size(); ++i) {
        BlockRun resumed(block, kBlockKey);
        for (std::size_t before = 0; before < i; ++before) {
            resumed.add(past[before]);
        }
        EXPECT_EQ(resumed.next(), i < past.size() ? std::optional(past[i].presented) : std::nullopt)
            << i;
    }
    EXPECT_NE(BlockRun(block, {1}).next(), past.front().presented);
}

TEST(Blocks, PresentEachSeriesToItsEndWithPracticeBeforeAndCatchTrialsBetween) {
    const Block block = mixed_block();
    const std::vector<PastBlockTrial> past = whole_run(block);
    std::map<TrialKind, int> of_kind;
    std::map<std::pair<int, double>, int> of_level; // of constant stimuli
    std::array<int, 3> measured{};
    for (const PastBlockTrial &trial : past) {
        if (trial.outcome.marked) {
            continue;
        }
        const BlockTrial &presented = trial.presented;
        ++of_kind[presented.kind];
        if (presented.kind == TrialKind::practice) {
            EXPECT_EQ(of_kind[TrialKind::measured] + of_kind[TrialKind::catch_trial], 0);
            EXPECT_GE(presented.level, 9.0);
        } else if (presented.kind == TrialKind::catch_trial) {
            EXPECT_EQ(presented.level, 10.0);
        } else {
            ++measured[static_cast<std::size_t>(presented.series)];
            ++of_level[{presented.series, presented.level}];
        }
    }
    EXPECT_EQ(measured, (std::array{60, 50, 60}));
    for (const double level : {1.0, 2.0, 3.0}) {
        EXPECT_EQ((of_level[{0, level}]), 20);
    }
    EXPECT_EQ((of_level[{2, 4.0}]), 30);
    // One in each 8; the last 8 may be incomplete.
    const int after_practice = of_kind[TrialKind::measured] + of_kind[TrialKind::catch_trial];
    EXPECT_GE(of_kind[TrialKind::catch_trial], after_practice / 8);
    EXPECT_LE(of_kind[TrialKind::catch_trial], after_practice / 8 + 1);
    EXPECT_GE(of_kind[TrialKind::practice], 6);
    EXPECT_LE(after_practice + of_kind[TrialKind::practice], max_trials(block));
}

TEST(Blocks, CatchTrialsComeAtDrawnPlacesOneInEachWindow) {
    std::vector<int> places;
    int after_practice = 0;
    for (const PastBlockTrial &trial : whole_run(mixed_block())) {
        if (trial.outcome.marked || trial.presented.kind == TrialKind::practice) {
            continue;
        }
        if (trial.presented.kind == TrialKind::catch_trial) {
            EXPECT_EQ(static_cast<std::size_t>(after_practice / 8), places.size());
            places.push_back(after_practice % 8);
        }
        ++after_practice;
    }
    std::ranges::sort(places);
    EXPECT_GE(places.size(), 20U);
    EXPECT_LT(places.front(), 2); // of more than 20 places from 0 to 7
    EXPECT_GT(places.back(), 5);
}

TEST(Blocks, SeriesAndTracksStayTogether) {
    std::map<int, int> trials;                   // of each series
    std::map<int, int> of_track{{0, 0}, {1, 0}}; // of the staircases
    int changes = 0;
    int before = -1;
    for (const PastBlockTrial &trial : whole_run(mixed_block())) {
        if (trial.outcome.marked || trial.presented.kind != TrialKind::measured) {
            continue;
        }
        ++trials[trial.presented.series];
        changes += trial.presented.series != before ? 1 : 0;
        before = trial.presented.series;
        if (trials[1] < 50 && trials[0] < 60 && trials[2] < 60) { // none is done
            const auto [least, most] = std::minmax({trials[0], trials[1], trials[2]});
            EXPECT_LE(most - least, kMaxLead);
        }
        if (trial.presented.series == 1) {
            ++of_track[trial.presented.track];
            EXPECT_LE(std::abs(of_track[0] - of_track[1]), kMaxLead);
        }
    }
    EXPECT_GT(changes, 80);  // of 170 trials: interleaved,
    EXPECT_LT(changes, 150); // and not in turn
}

TEST(Blocks, DrawTheTargetOfEachTrialAlike) {
    std::array<int, 4> counts{};
    Block block = mixed_block();
    block.series = {ConstantStimuli{{1.0}, 1000, 4}};
    for (const PastBlockTrial &trial : whole_run(block)) {
        ASSERT_LT(static_cast<std::size_t>(trial.presented.target), counts.size());
        ++counts[static_cast<std::size_t>(trial.presented.target)];
    }
    const int all = counts[0] + counts[1] + counts[2] + counts[3];
    for (const int count : counts) {
        EXPECT_NEAR(count, all / 4.0, 4.0 * std::sqrt(all * 0.25 * 0.75));
    }
    block.task = {TaskKind::yes_no, 2, 0.5};
    for (const PastBlockTrial &trial : whole_run(block)) {
        EXPECT_EQ(trial.presented.target, 0);
    }
}

TEST(Blocks, PracticeEndsWhenItIsUnderstood) {
    Block block = mixed_block();
    block.catch_trials = {};
    const auto practised = [&](const auto &is_correct) {
        BlockRun run(block, kBlockKey);
        int trials = 0;
        while (run.next()->kind == TrialKind::practice) {
            run.add({*run.next(), {is_correct(trials), 0.0, false}});
            ++trials;
        }
        return trials;
    };
    EXPECT_EQ(practised([](int) { return true; }), 6);
    EXPECT_EQ(practised([](int i) { return i != 4; }), 8);
    EXPECT_EQ(practised([](int) { return false; }), 20);
    block.practice = {};
    EXPECT_EQ(practised([](int) { return true; }), 0);
}

TEST(Blocks, EndUnfinishedAfterTooManyMarkedTrials) {
    Block block = mixed_block();
    block.max_marked = 3;
    BlockRun run(block, kBlockKey);
    for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(run.state(), BlockState::running);
        run.add({run.next().value(), {false, 0.0, true}});
    }
    EXPECT_EQ(run.state(), BlockState::too_many_marked);
    EXPECT_FALSE(run.next().has_value());
}

TEST(Blocks, SayWhatIsWrongWithThem) {
    EXPECT_EQ(validate(mixed_block()), "");
    Block bad = mixed_block();
    bad.series.clear();
    EXPECT_EQ(validate(bad), "series (how many) is 0; it must be from 1 to 100");
    bad = mixed_block();
    bad.series[2] = ConstantStimuli{{1.0}, 1, 0};
    EXPECT_EQ(validate(bad), "series[2]: blocks is 0; it must be from 1 to 1000");
    bad = mixed_block();
    bad.practice.levels.clear();
    EXPECT_EQ(validate(bad), "practice.levels is empty; it must have at least one");
    bad = mixed_block();
    bad.practice.min_trials = 21;
    EXPECT_EQ(validate(bad), "practice.fewest_trials is 21; it must be from 0 to 20");
    bad = mixed_block();
    bad.catch_trials.one_in = 1;
    EXPECT_EQ(validate(bad), "catch_trials.one_in is 1; it must be from 2 to 1000");
    bad = mixed_block();
    bad.catch_trials.levels.clear();
    EXPECT_EQ(validate(bad), "catch_trials.levels is empty; it must have at least one");
    bad = mixed_block();
    bad.task.alternatives = 1;
    EXPECT_EQ(validate(bad), "alternatives is 1; it must be from 2 to 8");
    bad = mixed_block();
    bad.max_marked = -1;
    EXPECT_EQ(validate(bad), "most_marked is -1; it must be from 0 to 10000");
}

} // namespace
} // namespace springdrive::study
