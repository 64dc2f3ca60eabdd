// A block of trials without a break: practice first, then series of trials, one per condition and
// each by its own method, interleaved by chance, with catch trials between them. The whole
// sequence is a function of the specification, a random key and the trials so far.
//
// - Practice trials take series in turn and their levels by chance; no method learns of them.
// - The next series is drawn from those that are not done and are less than `kMaxLead` trials
//   ahead of the one that is furthest behind (tracks of staircases likewise).
// - Of each `one_in` trials after practice, one is a catch trial, at a drawn place: an obvious
//   stimulus, or none. No method learns of it.
// - The interval or place of the stimulus is drawn anew for each trial.
// - A marked trial did not happen: it takes part in no count, nothing learns of its answer, and its
//   level is presented again later in the block, as `Outcome::marked` says. A marked practice or
//   catch trial is presented again at once, with another draw of interval or place.
#pragma once

#include "engine/study/methods/method.h"
#include "engine/study/methods/random_key.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::study {

/// Ends after `min_trials` once the last `correct_in_a_row` were correct, or after
/// `max_trials`.
struct Practice {
    std::vector<double> levels; ///< drawn from; may be empty without practice
    int min_trials = 0;
    int correct_in_a_row = 0; ///< 0: does not matter
    int max_trials = 0;       ///< 0: no practice

    friend bool operator==(const Practice &, const Practice &) = default;
};

struct CatchTrials {
    std::vector<double> levels; ///< drawn from; may be empty without catch trials
    int one_in = 0;             ///< 0: none

    friend bool operator==(const CatchTrials &, const CatchTrials &) = default;
};

inline constexpr auto kPracticeFields = std::to_array<Field<Practice>>({
    {"levels", &Practice::levels, "drawn from by chance", kTypedLevel},
    {"fewest_trials", &Practice::min_trials,
     "practice ends after so many once the last `correct_in_a_row` were right", 0.0, 1000.0},
    {"correct_in_a_row", &Practice::correct_in_a_row, "0: does not matter", 0.0, 1000.0},
    {"most_trials", &Practice::max_trials,
     "practice ends after so many at the latest; 0: no practice", 0.0, 1000.0},
});

inline constexpr auto kCatchTrialFields = std::to_array<Field<CatchTrials>>({
    {"levels", &CatchTrials::levels, "drawn from by chance", kTypedLevel},
    {"one_in", &CatchTrials::one_in, "of so many trials one is a catch trial; 0: none", 0.0,
     1000.0},
});

struct Block {
    Task task;
    std::vector<Method> series; ///< one per condition of the block
    Practice practice;
    CatchTrials catch_trials;
    int max_marked = 20; ///< the block ends, unfinished, with the next marked trial after these

    friend bool operator==(const Block &, const Block &) = default;
};

/// Empty if the block can be run; else the first bad key, with value and range.
[[nodiscard]] std::string validate(const Block &block);

/// An upper bound of its trials, not counting marked ones.
[[nodiscard]] int max_trials(const Block &block);

enum class TrialKind : std::uint8_t { practice, catch_trial, measured };

/// By the number of the kind, as in stores and exports.
inline constexpr std::array<std::string_view, 3> kTrialKindNames{"practice", "catch", "measured"};

/// What is to be presented.
struct BlockTrial {
    TrialKind kind = TrialKind::measured;
    int series = 0;     ///< index into Block::series
    int track = 0;      ///< of staircases, else 0
    double level = 0.0; ///< of an adjustment: where it starts
    int target = 0;     ///< forced choice: the interval or place of the stimulus, from 0

    friend bool operator==(const BlockTrial &, const BlockTrial &) = default;
};

/// A trial that was run.
struct PastBlockTrial {
    BlockTrial presented;
    Outcome outcome;

    friend bool operator==(const PastBlockTrial &, const PastBlockTrial &) = default;
};

enum class BlockState : std::uint8_t { running, complete, too_many_marked };

/// A block while it runs, trial by trial.
class BlockRun {
public:
    /// @pre validate(block) is empty
    BlockRun(const Block &block, RandomKey key);

    /// The same however often it is asked; nothing unless the state is `running`.
    [[nodiscard]] std::optional<BlockTrial> next() const;

    /// @pre the state is `running`; the trial is `next()`
    void add(const PastBlockTrial &trial);

    [[nodiscard]] BlockState state() const;

private:
    [[nodiscard]] bool is_practising() const;
    [[nodiscard]] bool is_catch_due() const;
    [[nodiscard]] BlockTrial practice_trial() const;
    [[nodiscard]] BlockTrial catch_trial() const;
    [[nodiscard]] BlockTrial measured_trial() const;

    Block block_;
    RandomKey key_;
    std::vector<MethodRun> runs_;
    // Trials that were not marked:
    std::vector<int> trials_of_series_; ///< measured ones
    int practised_ = 0;
    int correct_in_a_row_ = 0; ///< in practice
    int after_practice_ = 0;   ///< measured and catch trials
    // Others:
    int marked_ = 0;
    int all_ = 0; ///< marked ones too
};

// The order of conditions or blocks, by participant number: what comes before something else is
// balanced over participants.

enum class Counterbalancing : std::uint8_t {
    fixed, ///< as listed, for everybody
    /// All n! orders in turn; each n consecutive participants together have each condition once in
    /// each place.
    full,
    /// n orders in turn, 2n if n is odd, in which each condition is once (twice) in each place and
    /// is once (twice) directly followed by each other (Williams 1949, Aust. J. Chem. 2, 149).
    balanced_latin_square,
    random, ///< drawn for each participant
};

/// By the number of the kind, as in protocol files.
inline constexpr std::array<std::string_view, 4> kCounterbalancingNames{
    "fixed", "full", "balanced_latin_square", "random"};

/// Of `full`: 720 orders.
inline constexpr int kMaxFullyCounterbalanced = 6;

/// Empty if so many conditions can be ordered so.
[[nodiscard]] std::string validate(Counterbalancing kind, int conditions);

/// The number of participants, or a multiple of it, that balances the orders; 1 if none does.
[[nodiscard]] int participants_to_balance(Counterbalancing kind, int conditions);

/// Conditions 0 to n − 1 in the participant's order.
/// @param participant  counted from 1
/// @param key          of the study, not of the participant; only `random` uses it
[[nodiscard]] std::vector<int> order_of(Counterbalancing kind, int conditions, int participant,
                                        RandomKey key);

} // namespace springdrive::study
