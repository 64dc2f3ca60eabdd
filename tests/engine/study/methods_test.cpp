// Covers engine/study/methods/{random_key,method,block}.cpp and base/split_mix.h: what all methods
// promise, and what they refuse.
#include "base/split_mix.h"
#include "engine/study/methods/block.h"
#include "engine/study/methods/method.h"
#include "engine/study/methods/random_key.h"
#include "tests/engine/study/refusals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace springdrive::study {
namespace {

/// Σ (observed − expected)²/expected for equally likely cells.
double chi_squared(const std::vector<int> &counts) {
    double total = 0.0;
    for (const int count : counts) {
        total += count;
    }
    const double expected = total / static_cast<double>(counts.size());
    double sum = 0.0;
    for (const int count : counts) {
        sum += (count - expected) * (count - expected) / expected;
    }
    return sum;
}

TEST(SplitMix, GivesThePublishedSequence) {
    // The first values for seed 1234567 (rosettacode.org, Pseudo-random numbers/Splitmix64).
    constexpr std::uint64_t kSeed = 1234567;
    EXPECT_EQ(split_mix::value(kSeed, 0), 6457827717110365317U);
    EXPECT_EQ(split_mix::value(kSeed, 1), 3203168211198807973U);
    EXPECT_EQ(split_mix::value(kSeed, 2), 9817491932198370423U);
}

TEST(RandomKey, ChildrenAreUniformAndIndependentOfTheirNeighbours) {
    // 16 × 16 cells of a child's value and that of the next child, of the next key's same child,
    // and of its own child: χ² with 255 degrees of freedom has mean 255 and deviation 22.6.
    constexpr int kPairs = 100'000;
    std::array<std::vector<int>, 3> counts;
    counts.fill(std::vector<int>(256, 0));
    const auto cell = [](double value) { return static_cast<std::size_t>(value * 16.0); };
    for (int i = 0; i < kPairs; ++i) {
        const auto number = static_cast<std::uint64_t>(i);
        const RandomKey one = child(key_of(1, 1), number);
        const std::size_t row = 16 * cell(uniform(one));
        ++counts[0][row + cell(uniform(child(key_of(1, 1), number + 1)))];
        ++counts[1][row + cell(uniform(child(key_of(1, 2), number)))];
        ++counts[2][row + cell(uniform(child(one, 0)))];
    }
    for (const std::vector<int> &table : counts) {
        EXPECT_NEAR(chi_squared(table), 255.0, 4.0 * 22.6);
    }
}

TEST(RandomKey, ShufflesIntoAllOrdersAlike) {
    std::map<std::vector<int>, int> seen;
    for (std::uint64_t i = 0; i < 24'000; ++i) {
        std::vector<int> order{0, 1, 2, 3};
        shuffle(child(key_of(7, 3), i), std::span(order));
        ++seen[order];
    }
    std::vector<int> counts;
    for (const auto &[order, count] : seen) {
        counts.push_back(count);
    }
    ASSERT_EQ(counts.size(), 24U);
    EXPECT_NEAR(chi_squared(counts), 23.0, 4.0 * std::sqrt(46.0)); // 23 degrees of freedom
}

TEST(RandomKey, DependsOnSeedAndParticipant) {
    EXPECT_EQ(key_of(1, 2), key_of(1, 2));
    EXPECT_NE(key_of(1, 2), key_of(2, 1));
    EXPECT_NE(key_of(1, 2), key_of(1, 3));
    EXPECT_NE(child({5}, 0), RandomKey{5});
}

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
    const auto staircases = [&](const auto &change) {
        return error(testing::spoilt(two_tracks(), change));
    };
    const auto quest = [&](const auto &change) {
        return error(testing::spoilt(quest_of_two(), change));
    };
    const auto adjusted = [&](Adjustment method) { return validate(Method(method), adjusting); };
    using S = Staircases;
    using Q = QuestPlus;
    testing::expect_refusals({
        {error(ConstantStimuli{}), "levels has 0 levels; it must have at least 1"},
        {error(ConstantStimuli{{1.0, 1.0}, 1, 1}), "levels has 1 after 1"},
        {error(ConstantStimuli{{1.0}, 0, 1}), "repetitions is 0; it must be from 1 to 1000"},
        {staircases([](S &s) { s.correct_for_down = 1; }),
         "correct_for_down is 1 and up_to_down 1, which converges to 0.5 correct"},
        {staircases([](S &s) { s.steps[1].from_reversal = 0; }),
         "steps[1].from_reversal is 0; it must be from 1 to 1000"},
        {staircases([](S &s) { s.steps[0].size = 1.0; }),
         "steps[0].size is 1; it must be a finite number above 1"},
        {staircases([](S &s) { s.steps.clear(); }), "steps is empty"},
        {staircases([](S &s) { s.start_levels = {}; }),
         "start_levels (how many) is 0; it must be from 1 to 16"},
        {staircases([](S &s) { s.start_levels = {9.0}; }),
         "start_levels (each) is 9; it must be from 0.125 to 8"},
        {quest([](Q &q) { q.levels.clear(); }), "levels has 0 levels; it must have at least 2"},
        {quest([](Q &q) { q.guess.prior = known(0.25); }),
         "guess is from 0.25 to 0.25; in this task it must be from 0.5 to 0.5"},
        {validate(
             Method(testing::spoilt(quest_of_two(), [](Q &q) { q.guess.prior = known(0.25); })),
             Task{TaskKind::forced_choice_by_place, 4, 0.5}),
         ""},
        {quest([](Q &q) { q.slope.points = 1001; }), "slope.points is 1001; it must be from 1"},
        {quest([](Q &q) {
             q.threshold.points = q.slope.points = 1000;
             q.lapse = {{Scale::linear, 0.0, 0.1}, 2};
         }),
         "levels times all points is 1e+07; it must be from 1 to 5e+06"},
        {quest([](Q &q) {
             q.lapse = {{Scale::linear, 0.0, 0.6}, 3};
         }),
         "lapse.maximum is 0.6; it must be from 0 to 0.5"},
        {quest([](Q &q) { q.threshold.prior.minimum = 1e-300; }),
         "threshold.minimum is 1e-300; it must be from 1e-06 to 1e+06"},
        {quest([](Q &q) { q.slope.prior.minimum = 1e-300; }), "slope.minimum is 1e-300"},
        {quest([](Q &q) { q.min_trials = 26; }), "fewest_trials is 26; it must be from 1 to 25"},
        {adjusted({Scale::linear, 0.0, 2.0, 0.0, 1.0, 5}),
         "maximum_start is 2; it must be from 0 to 1"},
        {adjusted({Scale::logarithmic, 0.5, 1.0, 0.0, 1.0, 5}),
         "minimum_level is 0; it must be from 1e-06 to 1e+06"},
        {adjusted({Scale::linear, 0.0, 1.0, 0.0, 1.0, 0}),
         "settings is 0; it must be from 1 to 1000"},
        {validate(Task{}), ""},
        {validate(Task{TaskKind::forced_choice_by_interval, 9, 0.5}),
         "alternatives is 9; it must be from 2 to 8"},
        {validate(Task{TaskKind::yes_no, 3, 0.5}), "alternatives is 3; it must be from 2 to 2"},
        {validate(Task{TaskKind::yes_no, 2, 0.6}),
         "largest_false_alarm_rate is 0.6; it must be from 0 to 0.5"},
    });
    const GuessRange of_four = guess_range({TaskKind::forced_choice_by_place, 4, 0.5});
    EXPECT_EQ(of_four.minimum, 0.25);
    EXPECT_EQ(of_four.maximum, 0.25);
    EXPECT_EQ(guess_range({TaskKind::yes_no, 2, 0.3}).minimum, 0.0);
    EXPECT_EQ(guess_range({TaskKind::yes_no, 2, 0.3}).maximum, 0.3);
}

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

TEST(Blocks, InterleaveSeriesTracksAndCatchTrialsByChance) {
    std::vector<int> places; // of catch trials, one in each window of eight
    int after_practice = 0;
    std::map<int, int> trials;                   // of each series
    std::map<int, int> of_track{{0, 0}, {1, 0}}; // of the staircases
    int changes = 0;
    int before = -1;
    const Block block = mixed_block();
    const std::vector<PastBlockTrial> past = whole_run(block);
    for (const PastBlockTrial &trial : past) {
        if (trial.outcome.marked || trial.presented.kind == TrialKind::practice) {
            continue;
        }
        if (trial.presented.kind == TrialKind::catch_trial) {
            EXPECT_EQ(static_cast<std::size_t>(after_practice++ / 8), places.size());
            places.push_back((after_practice - 1) % 8);
            continue;
        }
        ++after_practice;
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
    std::ranges::sort(places);
    EXPECT_GE(places.size(), 20U);
    EXPECT_LT(places.front(), 2); // of more than 20 places from 0 to 7
    EXPECT_GT(places.back(), 5);
    EXPECT_NE(BlockRun(block, {1}).next(), past.front().presented); // with another key
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

TEST(Blocks, SayWhatIsWrongWithThem) {
    const auto error = [](const auto &change) {
        return validate(testing::spoilt(mixed_block(), change));
    };
    testing::expect_refusals({
        {error([](Block &) {}), ""},
        {error([](Block &b) { b.series.clear(); }), "series (how many) is 0; it must be from 1"},
        {error([](Block &b) {
             b.series[2] = ConstantStimuli{{1.0}, 1, 0};
         }),
         "series[2]: blocks is 0; it must be from 1 to 1000"},
        {error([](Block &b) { b.practice.levels.clear(); }), "practice.levels is empty"},
        {error([](Block &b) { b.practice.min_trials = 21; }),
         "practice.fewest_trials is 21; it must be from 0 to 20"},
        {error([](Block &b) { b.catch_trials.one_in = 1; }),
         "catch_trials.one_in is 1; it must be from 2 to 1000"},
        {error([](Block &b) { b.catch_trials.levels.clear(); }), "catch_trials.levels is empty"},
        {error([](Block &b) { b.task.alternatives = 1; }), "alternatives is 1; it must be from 2"},
        {error([](Block &b) { b.max_marked = -1; }), "most_marked is -1; it must be from 0"},
    });
}

using Orders = std::vector<std::vector<int>>;

Orders orders_of(Counterbalancing kind, int conditions, int first, int participants) {
    Orders orders;
    for (int i = 0; i < participants; ++i) {
        orders.push_back(order_of(kind, conditions, first + i, key_of(1, 0)));
    }
    return orders;
}

/// The numbers of times that each of `all` pairs occurs, each once.
template <typename Counts> std::set<int> different(const Counts &counts, std::size_t all) {
    EXPECT_EQ(counts.size(), all);
    std::set<int> numbers;
    for (const auto &[of, count] : counts) {
        numbers.insert(count);
    }
    return numbers;
}

/// How often each condition is in each place.
std::set<int> counts_of_places(const Orders &orders) {
    std::map<std::pair<int, std::size_t>, int> counts;
    for (const std::vector<int> &order : orders) {
        for (std::size_t place = 0; place < order.size(); ++place) {
            ++counts[{order[place], place}];
        }
    }
    return different(counts, orders.front().size() * orders.front().size());
}

/// How often each condition directly follows each other one.
std::set<int> counts_of_neighbours(const Orders &orders) {
    std::map<std::pair<int, int>, int> counts;
    for (const std::vector<int> &order : orders) {
        for (std::size_t place = 1; place < order.size(); ++place) {
            ++counts[{order[place - 1], order[place]}];
        }
    }
    return different(counts, orders.front().size() * (orders.front().size() - 1));
}

TEST(Counterbalancing, BalancedLatinSquareBalancesPlacesAndNeighbours) {
    for (int n = 2; n <= 12; ++n) {
        const int participants =
            participants_to_balance(Counterbalancing::balanced_latin_square, n);
        EXPECT_EQ(participants, n % 2 == 0 ? n : 2 * n);
        const Orders orders =
            orders_of(Counterbalancing::balanced_latin_square, n, 1, participants);
        const std::set<int> once{participants / n};
        EXPECT_EQ(counts_of_places(orders), once) << n;
        EXPECT_EQ(counts_of_neighbours(orders), once) << n;
    }
}

TEST(Counterbalancing, FullHasEachOrderOnceAndALatinSquareInEachNParticipants) {
    for (int n = 2; n <= kMaxFullyCounterbalanced; ++n) {
        const int participants = participants_to_balance(Counterbalancing::full, n);
        const Orders orders = orders_of(Counterbalancing::full, n, 1, participants);
        EXPECT_EQ(std::set(orders.begin(), orders.end()).size(), orders.size()) << n;
        for (int first = 1; first <= participants; first += n) {
            EXPECT_EQ(counts_of_places(orders_of(Counterbalancing::full, n, first, n)),
                      std::set<int>{1});
        }
        // All orders: each neighbour (n − 1)! times.
        EXPECT_EQ(counts_of_neighbours(orders), std::set<int>{participants / n}) << n;
    }
    EXPECT_EQ(participants_to_balance(Counterbalancing::full, 6), 720);
}

TEST(Counterbalancing, StartsAgainWhenTheOrdersAreUsedUp) {
    EXPECT_EQ(orders_of(Counterbalancing::full, 3, 1, 6),
              orders_of(Counterbalancing::full, 3, 7, 6));
    EXPECT_EQ(orders_of(Counterbalancing::balanced_latin_square, 5, 1, 10),
              orders_of(Counterbalancing::balanced_latin_square, 5, 11, 10));
}

TEST(Counterbalancing, RandomOrdersAreThoseOfTheParticipant) {
    const Orders orders = orders_of(Counterbalancing::random, 4, 1, 200);
    EXPECT_EQ(std::set(orders.begin(), orders.end()).size(), 24U);
    EXPECT_EQ(orders, orders_of(Counterbalancing::random, 4, 1, 200));
    EXPECT_EQ(order_of(Counterbalancing::fixed, 3, 5, {}), (std::vector{0, 1, 2}));
    EXPECT_EQ(order_of(Counterbalancing::balanced_latin_square, 1, 5, {}), std::vector{0});
}

TEST(Counterbalancing, SaysHowManyConditionsItCanOrder) {
    EXPECT_EQ(validate(Counterbalancing::full, 6), "");
    EXPECT_NE(validate(Counterbalancing::full, 7), "");
    EXPECT_EQ(validate(Counterbalancing::balanced_latin_square, 7), "");
    EXPECT_EQ(validate(Counterbalancing::fixed, 0), "conditions is 0; it must be from 1 to 100");
}

} // namespace
} // namespace springdrive::study
