// Covers engine/study/methods/method.cpp, constant_stimuli.cpp and adjustment.cpp: what all methods
// promise, and what they refuse.
#include "engine/study/methods/method.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace springdrive::study {
namespace {

constexpr RandomKey kStudyKey{77};

QuestPlus quest_of_two() {
    QuestPlus method;
    method.levels = {0.25, 0.5, 1.0, 2.0, 4.0};
    method.threshold = {{Scale::logarithmic, 0.25, 4.0}, 12};
    method.slope = {{Scale::logarithmic, 1.0, 6.0}, 4};
    method.guess = {known(0.5), 1};
    method.lapse = {known(0.02), 1};
    method.min_trials = 5;
    method.max_trials = 25;
    method.threshold_deviation = 0.3;
    return method;
}

Staircases two_tracks() {
    Staircases method;
    method.scale = Scale::logarithmic;
    method.minimum_level = 0.125;
    method.maximum_level = 8.0;
    method.start_levels = {4.0, 0.25};
    method.steps = {{0, 2.0}, {2, 1.25}};
    method.reversals = 6;
    return method;
}

std::vector<Method> one_of_each() {
    return {ConstantStimuli{{0.5, 1.0, 2.0}, 2, 3}, two_tracks(), quest_of_two(),
            Adjustment{Scale::logarithmic, 0.5, 2.0, 0.1, 10.0, 12}};
}

/// An answer that depends on the number of the trial only; one in seven is marked.
Outcome answer_to(const MethodTrial &trial, std::uint64_t number) {
    const RandomKey key = child({5}, number);
    return {uniform(child(key, 0)) < (trial.level > 0.8 ? 0.9 : 0.5), uniform(child(key, 1)),
            uniform(child(key, 2)) < 1.0 / 7.0};
}

std::optional<MethodTrial> next_trial(const Method &method,
                                      const std::vector<PastMethodTrial> &past) {
    MethodRun run(method, kStudyKey);
    for (const PastMethodTrial &trial : past) {
        run.add(trial);
    }
    return run.next();
}

TEST(Methods, ResumedAtAnyTrialPresentWhatAnUndisturbedRunPresents) {
    for (const Method &method : one_of_each()) {
        MethodRun undisturbed(method, kStudyKey);
        std::vector<PastMethodTrial> past;
        while (!undisturbed.is_done()) {
            const std::optional<MethodTrial> trial = undisturbed.next();
            ASSERT_TRUE(trial.has_value());
            EXPECT_EQ(next_trial(method, past), trial);
            past.push_back({*trial, answer_to(*trial, past.size())});
            undisturbed.add(past.back());
        }
        EXPECT_FALSE(undisturbed.next().has_value());
        EXPECT_FALSE(next_trial(method, past).has_value());
        const auto unmarked = std::ranges::count_if(
            past, [](const PastMethodTrial &trial) { return !trial.outcome.marked; });
        EXPECT_LT(unmarked, std::ssize(past));
        EXPECT_LE(unmarked, max_trials(method));
        EXPECT_GT(unmarked, max_trials(method) / 8);
    }
}

TEST(Methods, LearnNothingFromMarkedTrials) {
    // Adaptive methods and adjustments go on as if the marked trial had not been, whatever was
    // answered in it: the levels of each track are those without marked trials.
    for (const Method &method : one_of_each()) {
        if (std::holds_alternative<ConstantStimuli>(method)) {
            continue;
        }
        std::array<std::map<int, std::vector<double>>, 2> levels; // of each track
        for (const bool with_marked : {false, true}) {
            MethodRun run(method, kStudyKey);
            std::map<int, std::uint64_t> answered;
            for (std::uint64_t i = 0; !run.is_done(); ++i) {
                const MethodTrial trial = run.next().value();
                if (with_marked && i % 3 == 1) {
                    run.add({trial, {i % 2 == 0, 99.0, true}});
                    continue;
                }
                levels[with_marked ? 1 : 0][trial.track].push_back(trial.level);
                Outcome outcome = answer_to(trial, answered[trial.track]++);
                outcome.marked = false;
                run.add({trial, outcome});
            }
        }
        EXPECT_EQ(levels[0], levels[1]);
        EXPECT_GE(levels[0][0].size(), 5U);
    }
}

TEST(ConstantStimuli, PresentsEachLevelEquallyOftenInEachBlock) {
    const ConstantStimuli method{{0.5, 1.0, 2.0}, 2, 40};
    ConstantStimuliRun run(method, kStudyKey);
    int repeated_orders = 0;
    std::vector<double> before;
    for (int block = 0; block < method.blocks; ++block) {
        std::vector<double> levels;
        for (int i = 0; i < 6; ++i) {
            levels.push_back(run.next()->level);
            run.add({*run.next(), {}});
        }
        repeated_orders += levels == before ? 1 : 0;
        before = levels;
        std::ranges::sort(levels);
        EXPECT_EQ(levels, (std::vector{0.5, 0.5, 1.0, 1.0, 2.0, 2.0}));
    }
    EXPECT_TRUE(run.is_done());
    EXPECT_LT(repeated_orders, 4); // 90 orders: less than one in 40 expected
}

TEST(ConstantStimuli, PresentsAMarkedLevelLaterInTheSameBlock) {
    ConstantStimuli method{{1.0, 2.0, 3.0, 4.0, 5.0}, 1, 1};
    std::map<int, int> delays;
    for (std::uint64_t i = 0; i < 400; ++i) {
        ConstantStimuliRun run(method, child(kStudyKey, i));
        const MethodTrial marked = run.next().value();
        run.add({marked, {false, 0.0, true}});
        std::vector<double> levels;
        while (!run.is_done()) {
            levels.push_back(run.next()->level);
            run.add({*run.next(), {}});
        }
        ASSERT_EQ(levels.size(), 5U);
        ++delays[static_cast<int>(std::ranges::find(levels, marked.level) - levels.begin())];
        std::ranges::sort(levels);
        EXPECT_EQ(levels, method.levels);
    }
    EXPECT_EQ(delays.size(), 4U); // never at once, else anywhere: 100 each, deviation 8.7
    for (const auto &[delay, count] : delays) {
        EXPECT_GE(delay, 1);
        EXPECT_NEAR(count, 100, 4 * 8.7);
    }
    // The last one of a block has nowhere else to go.
    method.levels = {1.0};
    ConstantStimuliRun run(method, kStudyKey);
    run.add({*run.next(), {false, 0.0, true}});
    EXPECT_EQ(run.next()->level, 1.0);
}

TEST(Adjustment, StartsUniformlyOnItsScale) {
    const Adjustment method{Scale::logarithmic, 0.5, 8.0, 0.1, 10.0, 1000};
    AdjustmentRun run(method, kStudyKey);
    double sum = 0.0;
    double lowest = 10.0;
    double highest = 0.0;
    while (!run.is_done()) {
        const double level = run.next()->level;
        sum += std::log(level);
        lowest = std::min(lowest, level);
        highest = std::max(highest, level);
        run.add({*run.next(), {}});
    }
    // ln 2 ± ln 16/√(12 · 1000)
    EXPECT_NEAR(sum / 1000.0, std::log(2.0), 4.0 * std::log(16.0) / std::sqrt(12'000.0));
    EXPECT_GE(lowest, 0.5);
    EXPECT_LT(lowest, 0.51);
    EXPECT_LE(highest, 8.0);
    EXPECT_GT(highest, 7.9);
}

TEST(Methods, SayWhatIsWrongWithThem) {
    const Task choice;
    const Task adjusting{TaskKind::adjustment, 2, 0.5};
    for (const Method &method : one_of_each()) {
        const bool adjusts = std::holds_alternative<Adjustment>(method);
        EXPECT_EQ(validate(method, adjusts ? adjusting : choice), "");
        EXPECT_NE(validate(method, adjusts ? choice : adjusting).find("adjustment"),
                  std::string::npos);
    }

    const auto error = [&](Method method) { return validate(method, choice); };
    EXPECT_EQ(error(ConstantStimuli{}), "levels has 0 levels; it must have at least 1");
    EXPECT_EQ(error(ConstantStimuli{{1.0, 1.0}, 1, 1}),
              "levels has 1 after 1; each must be above the one before");
    EXPECT_EQ(error(ConstantStimuli{{1.0}, 0, 1}), "repetitions is 0; it must be from 1 to 1000");

    Staircases staircases = two_tracks();
    staircases.correct_for_down = 1;
    EXPECT_EQ(error(staircases),
              "correct_for_down is 1 and up_to_down 1, which converges to 0.5 correct; it must be "
              "above 0.5, which is chance");
    staircases = two_tracks();
    staircases.steps[1].from_reversal = 0;
    EXPECT_EQ(error(staircases), "steps[1].from_reversal is 0; it must be from 1 to 1000");
    staircases = two_tracks();
    staircases.steps[0].size = 1.0;
    EXPECT_EQ(error(staircases), "steps[0].size is 1; it must be a finite number above 1");
    staircases = two_tracks();
    staircases.steps.clear();
    EXPECT_EQ(error(staircases), "steps is empty; it must have at least one");
    staircases = two_tracks();
    staircases.start_levels = {};
    EXPECT_EQ(error(staircases), "start_levels (how many) is 0; it must be from 1 to 16");
    staircases.start_levels = {9.0};
    EXPECT_EQ(error(staircases), "start_levels (each) is 9; it must be from 0.125 to 8");

    QuestPlus quest = quest_of_two();
    quest.levels.clear();
    EXPECT_EQ(error(quest), "levels has 0 levels; it must have at least 2");
    quest = quest_of_two();
    quest.guess = {known(0.25), 1};
    EXPECT_EQ(error(quest), "guess is from 0.25 to 0.25; in this task it must be from 0.5 to 0.5");
    EXPECT_EQ(validate(Method(quest), Task{TaskKind::forced_choice_by_place, 4, 0.5}), "");
    quest = quest_of_two();
    quest.threshold.points = 1000;
    quest.slope.points = 1001;
    EXPECT_EQ(error(quest), "slope.points is 1001; it must be from 1 to 1000");
    quest.slope.points = 1000;
    quest.lapse = {{Scale::linear, 0.0, 0.1}, 2};
    EXPECT_EQ(error(quest), "levels times all points is 1e+07; it must be from 1 to 5e+06");
    quest = quest_of_two();
    quest.lapse = {{Scale::linear, 0.0, 0.6}, 3};
    EXPECT_EQ(error(quest), "lapse.maximum is 0.6; it must be from 0 to 0.5");
    quest = quest_of_two();
    quest.threshold.prior.minimum = 1e-300;
    EXPECT_EQ(error(quest), "threshold.minimum is 1e-300; it must be from 1e-06 to 1e+06");
    quest = quest_of_two();
    quest.slope.prior.minimum = 1e-300;
    EXPECT_EQ(error(quest), "slope.minimum is 1e-300; it must be from 1e-06 to 1e+06");
    quest = quest_of_two();
    quest.min_trials = 26;
    EXPECT_EQ(error(quest), "fewest_trials is 26; it must be from 1 to 25");

    const auto adjusted = [&](Adjustment method) { return validate(Method(method), adjusting); };
    EXPECT_EQ(adjusted({Scale::linear, 0.0, 2.0, 0.0, 1.0, 5}),
              "maximum_start is 2; it must be from 0 to 1");
    EXPECT_EQ(adjusted({Scale::logarithmic, 0.5, 1.0, 0.0, 1.0, 5}),
              "minimum_level is 0; it must be from 1e-06 to 1e+06");
    EXPECT_EQ(adjusted({Scale::linear, 0.0, 1.0, 0.0, 1.0, 0}),
              "settings is 0; it must be from 1 to 1000");
}

TEST(Tasks, SayWhatIsWrongWithThem) {
    EXPECT_EQ(validate(Task{}), "");
    EXPECT_EQ(validate(Task{TaskKind::forced_choice_by_interval, 9, 0.5}),
              "alternatives is 9; it must be from 2 to 8");
    EXPECT_EQ(validate(Task{TaskKind::yes_no, 3, 0.5}),
              "alternatives is 3; it must be from 2 to 2");
    EXPECT_EQ(validate(Task{TaskKind::yes_no, 2, 0.6}),
              "largest_false_alarm_rate is 0.6; it must be from 0 to 0.5");
    EXPECT_EQ(guess_range({TaskKind::forced_choice_by_place, 4, 0.5}).maximum, 0.25);
    EXPECT_EQ(guess_range({TaskKind::forced_choice_by_place, 4, 0.5}).minimum, 0.25);
    EXPECT_EQ(guess_range({TaskKind::yes_no, 2, 0.3}).minimum, 0.0);
    EXPECT_EQ(guess_range({TaskKind::yes_no, 2, 0.3}).maximum, 0.3);
}

} // namespace
} // namespace springdrive::study
