#include "engine/study/methods/block.h"

#include "base/assertions.h"
#include "engine/study/methods/psychometric_function.h"

#include <fmt/core.h>

#include <algorithm>
#include <numeric>

namespace springdrive::study {

namespace {

/// What is drawn from the key of a block: each has a child of its own.
enum class Drawn : std::uint8_t {
    series_sequence, ///< of the series' methods
    turn,
    target,
    practice_level,
    catch_place,
    catch_series,
    catch_level,
};

RandomKey key_for(RandomKey block, Drawn what, int number) {
    return child(child(block, static_cast<std::uint64_t>(what)),
                 static_cast<std::uint64_t>(number));
}

std::string validate(const Practice &practice) {
    return first_of(
        {unless_finite("practice.levels", practice.levels),
         unless_from_to("practice.most_trials", practice.max_trials, 0,
                        kPracticeFields.back().range.maximum),
         unless_from_to("practice.fewest_trials", practice.min_trials, 0, practice.max_trials),
         unless_from_to("practice.correct_in_a_row", practice.correct_in_a_row, 0,
                        practice.max_trials),
         practice.max_trials > 0 && practice.levels.empty()
             ? std::string("practice.levels is empty; it must have at least one")
             : std::string()});
}

std::string validate(const CatchTrials &catch_trials) {
    return first_of({unless_finite("catch_trials.levels", catch_trials.levels),
                     catch_trials.one_in == 0
                         ? std::string()
                         : unless_from_to("catch_trials.one_in", catch_trials.one_in, 2,
                                          kCatchTrialFields.back().range.maximum),
                     catch_trials.one_in > 0 && catch_trials.levels.empty()
                         ? std::string("catch_trials.levels is empty; it must have at least one")
                         : std::string()});
}

std::vector<int> listed(int count) {
    std::vector<int> order(static_cast<std::size_t>(count));
    std::iota(order.begin(), order.end(), 0);
    return order;
}

int factorial(int n) { return n < 2 ? 1 : n * factorial(n - 1); }

/// Conditions 1 to n − 1 in each of their (n − 1)! orders behind condition 0, and each of these
/// turned by 0 to n − 1 places.
std::vector<int> full_order(int count, int index) {
    std::vector<int> order = listed(count);
    for (int i = 0; i < index / count; ++i) {
        std::next_permutation(order.begin() + 1, order.end());
    }
    std::rotate(order.begin(), order.begin() + index % count, order.end());
    return order;
}

/// The row 0, 1, n − 1, 2, n − 2, … plus `index`, mod n: its differences are all different, so each
/// ordered pair of neighbours occurs once in n rows. With an odd n each difference occurs once
/// forwards in these rows and once in their mirror images.
std::vector<int> williams_order(int count, int index) {
    std::vector<int> order;
    for (int place = 0; place < count; ++place) {
        const int zigzag = place % 2 == 1 ? (place + 1) / 2 : count - place / 2;
        order.push_back((zigzag + index) % count);
    }
    if (index >= count) {
        std::ranges::reverse(order);
    }
    return order;
}

} // namespace

std::string validate(const Block &block) {
    constexpr int kMaxSeries = 100;
    std::string error =
        first_of({validate(block.task),
                  unless_from_to("series (how many)", static_cast<double>(block.series.size()), 1,
                                 kMaxSeries),
                  validate(block.practice), validate(block.catch_trials),
                  unless_from_to("most_marked", block.max_marked, 0, 10000)});
    for (std::size_t i = 0; i < block.series.size() && error.empty(); ++i) {
        error = validate(block.series[i], block.task);
        if (!error.empty()) {
            error = fmt::format("series[{}]: {}", i, error);
        }
    }
    return error;
}

int max_trials(const Block &block) {
    int measured = 0;
    for (const Method &method : block.series) {
        measured += max_trials(method);
    }
    const int others_per_catch = block.catch_trials.one_in - 1;
    const int caught = others_per_catch > 0 ? measured / others_per_catch + 1 : 0;
    return block.practice.max_trials + measured + caught;
}

BlockRun::BlockRun(const Block &block, RandomKey key)
    : block_(block), key_(key), trials_of_series_(block.series.size(), 0) {
    for (std::size_t i = 0; i < block.series.size(); ++i) {
        runs_.emplace_back(block.series[i],
                           key_for(key, Drawn::series_sequence, static_cast<int>(i)));
    }
}

BlockState BlockRun::state() const {
    if (marked_ > block_.max_marked) {
        return BlockState::too_many_marked;
    }
    const bool all_done =
        std::ranges::all_of(runs_, [](const MethodRun &run) { return run.is_done(); });
    return all_done && !is_practising() ? BlockState::complete : BlockState::running;
}

std::optional<BlockTrial> BlockRun::next() const {
    if (state() != BlockState::running) {
        return std::nullopt;
    }
    BlockTrial trial = is_practising()  ? practice_trial()
                       : is_catch_due() ? catch_trial()
                                        : measured_trial();
    if (is_forced_choice(block_.task.kind)) {
        trial.target = static_cast<int>(below(key_for(key_, Drawn::target, all_),
                                              static_cast<std::size_t>(block_.task.alternatives)));
    }
    return trial;
}

void BlockRun::add(const PastBlockTrial &trial) {
    SPRINGDRIVE_ASSERT(state() == BlockState::running);
    ++all_;
    marked_ += trial.outcome.marked ? 1 : 0;
    if (trial.presented.kind == TrialKind::measured) {
        const auto series = static_cast<std::size_t>(trial.presented.series);
        SPRINGDRIVE_ASSERT(series < runs_.size());
        runs_[series].add({{trial.presented.level, trial.presented.track}, trial.outcome});
        trials_of_series_[series] += trial.outcome.marked ? 0 : 1;
    }
    if (trial.outcome.marked) {
        return;
    }
    if (trial.presented.kind == TrialKind::practice) {
        ++practised_;
        correct_in_a_row_ = trial.outcome.positive ? correct_in_a_row_ + 1 : 0;
    } else {
        ++after_practice_;
    }
}

bool BlockRun::is_practising() const {
    const Practice &practice = block_.practice;
    return practised_ < practice.max_trials &&
           (practised_ < practice.min_trials || correct_in_a_row_ < practice.correct_in_a_row);
}

bool BlockRun::is_catch_due() const {
    const int one_in = block_.catch_trials.one_in;
    if (one_in == 0) {
        return false;
    }
    const RandomKey key = key_for(key_, Drawn::catch_place, after_practice_ / one_in);
    return static_cast<std::size_t>(after_practice_ % one_in) ==
           below(key, static_cast<std::size_t>(one_in));
}

BlockTrial BlockRun::practice_trial() const {
    const std::vector<double> &levels = block_.practice.levels;
    const std::size_t level =
        below(key_for(key_, Drawn::practice_level, practised_), levels.size());
    return {TrialKind::practice, practised_ % static_cast<int>(block_.series.size()), 0,
            levels[level], 0};
}

BlockTrial BlockRun::catch_trial() const {
    const std::vector<double> &levels = block_.catch_trials.levels;
    const std::size_t series =
        below(key_for(key_, Drawn::catch_series, after_practice_), block_.series.size());
    const std::size_t level =
        below(key_for(key_, Drawn::catch_level, after_practice_), levels.size());
    return {TrialKind::catch_trial, static_cast<int>(series), 0, levels[level], 0};
}

BlockTrial BlockRun::measured_trial() const {
    std::vector<Interleaved> all;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
        all.push_back({trials_of_series_[i], runs_[i].is_done()});
    }
    const std::optional<std::size_t> turn = next_turn(all, key_for(key_, Drawn::turn, all_));
    SPRINGDRIVE_ASSERT(turn.has_value());
    const std::optional<MethodTrial> trial = runs_[*turn].next();
    SPRINGDRIVE_ASSERT(trial.has_value());
    return {TrialKind::measured, static_cast<int>(*turn), trial->track, trial->level, 0};
}

std::string validate(Counterbalancing kind, int conditions) {
    constexpr int kMax = 100;
    return unless_from_to("conditions", conditions, 1,
                          kind == Counterbalancing::full ? kMaxFullyCounterbalanced : kMax);
}

int participants_to_balance(Counterbalancing kind, int conditions) {
    switch (kind) {
    case Counterbalancing::full:
        return factorial(conditions);
    case Counterbalancing::balanced_latin_square:
        return conditions % 2 == 0 || conditions == 1 ? conditions : 2 * conditions;
    case Counterbalancing::fixed:
    case Counterbalancing::random:
        break;
    }
    return 1;
}

std::vector<int> order_of(Counterbalancing kind, int conditions, int participant, RandomKey key) {
    SPRINGDRIVE_ASSERT(participant >= 1 && validate(kind, conditions).empty());
    const int index = (participant - 1) % participants_to_balance(kind, conditions);
    switch (kind) {
    case Counterbalancing::full:
        return full_order(conditions, index);
    case Counterbalancing::balanced_latin_square:
        return williams_order(conditions, index);
    case Counterbalancing::fixed:
    case Counterbalancing::random:
        break;
    }
    std::vector<int> order = listed(conditions);
    if (kind == Counterbalancing::random) {
        shuffle(child(key, static_cast<std::uint64_t>(participant)), std::span(order));
    }
    return order;
}

} // namespace springdrive::study
