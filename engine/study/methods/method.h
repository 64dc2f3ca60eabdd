// Methods of psychophysics: which level comes next, by constant stimuli, adjustment, staircases or
// QUEST+.
#pragma once

#include "engine/study/methods/psychometric_function.h"
#include "engine/study/methods/random_key.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace springdrive::study {

// The method of constant stimuli: every level as often as every other, in an order by chance.

/// `blocks` times a random order of `repetitions` presentations of each level: a drift in time
/// reaches all levels alike, to within a block.
struct ConstantStimuli {
    std::vector<double> levels; ///< rising
    int repetitions = 1;        ///< of each level in one block
    int blocks = 20;

    friend bool operator==(const ConstantStimuli &, const ConstantStimuli &) = default;
};

inline constexpr auto kConstantStimuliFields = std::to_array<Field<ConstantStimuli>>({
    {"levels", &ConstantStimuli::levels, "that are presented, rising", kTypedLevel, "", kRequired},
    {"repetitions", &ConstantStimuli::repetitions, "of each level in one round", 1.0, 1000.0},
    {"blocks", &ConstantStimuli::blocks, "rounds through all levels, each in an order by chance",
     1.0, 1000.0},
});

/// Empty if the method can be used; else the first bad key, with value and range.
[[nodiscard]] std::string validate(const ConstantStimuli &method);

[[nodiscard]] int max_trials(const ConstantStimuli &method);

/// The method while it runs; see MethodRun.
class ConstantStimuliRun {
public:
    ConstantStimuliRun(const ConstantStimuli &method, RandomKey key);

    [[nodiscard]] bool is_done() const { return left_.empty(); }
    [[nodiscard]] std::optional<MethodTrial> next() const;
    void add(const PastMethodTrial &trial);

private:
    void start_block();

    ConstantStimuli method_;
    RandomKey key_;
    std::vector<double> left_; ///< in the present block, the next one first
    int blocks_started_ = 0;
    std::uint64_t trials_ = 0; ///< marked ones too
};

// The method of adjustment: a trial starts at a drawn level, which the participant changes; its
// result is the setting.

struct Adjustment {
    Scale scale = Scale::linear; ///< on which starts are drawn and settings are averaged
    double minimum_start = 0.0;  ///< starts are uniform on the scale between both
    double maximum_start = 1.0;
    double minimum_level = 0.0; ///< reach of the settings
    double maximum_level = 1.0;
    int settings = 10;

    friend bool operator==(const Adjustment &, const Adjustment &) = default;
};

inline constexpr auto kAdjustmentFields = std::to_array<Field<Adjustment>>({
    {"scale", choice_of<&Adjustment::scale>(kScaleNames), "on which starts are drawn"},
    {"minimum_level", &Adjustment::minimum_level, "a step beyond ends here", kTypedLevel},
    {"maximum_level", &Adjustment::maximum_level, "and here", kTypedLevel},
    {"minimum_start", &Adjustment::minimum_start, "starts are drawn from here", kTypedLevel},
    {"maximum_start", &Adjustment::maximum_start, "to here", kTypedLevel},
    {"settings", &Adjustment::settings, "how many are made", 1.0, 1000.0},
});

/// Empty if the method can be used; else the first bad key, with value and range.
[[nodiscard]] std::string validate(const Adjustment &method);

[[nodiscard]] inline int max_trials(const Adjustment &method) { return method.settings; }

/// The method while it runs; see MethodRun.
class AdjustmentRun {
public:
    AdjustmentRun(const Adjustment &method, RandomKey key) : method_(method), key_(key) {}

    [[nodiscard]] bool is_done() const { return settings_ >= method_.settings; }
    [[nodiscard]] std::optional<MethodTrial> next() const;
    void add(const PastMethodTrial &trial) { settings_ += trial.outcome.marked ? 0 : 1; }

private:
    Adjustment method_;
    RandomKey key_;
    int settings_ = 0;
};

// Up-down staircases: n correct answers in a row (or "yes") lower the level, one wrong answer
// raises it. Transformed (n > 1, Levitt 1971), weighted (steps up and down of different size,
// Kaernbach 1991), or both; one track or several interleaved ones.
//
// A step down ends a run of n correct answers, a step up any other run. At a level where an answer
// is correct with probability p a run ends downwards with probability pⁿ, and the steps cancel on
// average where pⁿ Δ₋ = (1 − pⁿ) Δ₊, so a track converges to the level at which
//
//   p = (Δ₊/(Δ₊ + Δ₋))^(1/n):
//
// 0.5^(1/n) with equal steps (Levitt 1971, J. Acoust. Soc. Am. 49, 467, table I), Δ₊/(Δ₊ + Δ₋) with
// n = 1 (Kaernbach 1991, Perception & Psychophysics 49, 227, eq. (1)). It holds in the limit of
// small steps; the mean level of a track is off by up to a quarter of its larger step, as the
// stationary distribution of its Markov chain says (tests/engine/study/adaptive_methods_test.cpp).

/// A size of the step down, in force from a number of reversals on.
struct StepSize {
    int from_reversal = 0;
    double size = 1.0; ///< linear: in units of the level; logarithmic: the ratio of levels, above 1

    friend bool operator==(const StepSize &, const StepSize &) = default;
};

struct Staircases {
    Scale scale = Scale::linear;
    std::vector<double> start_levels; ///< one per track
    double minimum_level = 0.0;       ///< a step beyond ends here
    double maximum_level = 1.0;       ///< and here
    int correct_for_down = 2;         ///< n
    double up_to_down = 1.0;          ///< Δ₊/Δ₋, on the scale
    std::vector<StepSize> steps;      ///< rising in `from_reversal`, from 0
    int reversals = 10;               ///< a track ends after so many; 0: by `trials` alone
    int trials = 60;                  ///< a track ends after so many at the latest

    friend bool operator==(const Staircases &, const Staircases &) = default;
};

inline constexpr auto kStepFields = std::to_array<Field<StepSize>>({
    {"from_reversal", &StepSize::from_reversal, "this step is in force from so many reversals on",
     0.0, 1000.0},
    {"size", &StepSize::size,
     "of the step down: a difference of levels, or on a logarithmic scale their ratio", 0.0,
     kMaxTyped},
});

inline constexpr auto kStaircaseFields = std::to_array<Field<Staircases>>({
    {"scale", choice_of<&Staircases::scale>(kScaleNames), "on which levels are stepped"},
    {"start_levels", &Staircases::start_levels, "one for each track; tracks are interleaved",
     kTypedLevel, "", kRequired},
    {"minimum_level", &Staircases::minimum_level, "a step beyond ends here", kTypedLevel},
    {"maximum_level", &Staircases::maximum_level, "and here", kTypedLevel},
    {"correct_for_down", &Staircases::correct_for_down,
     "so many right answers in a row lower the level", 1.0, 10.0},
    {"up_to_down", &Staircases::up_to_down, "step up over step down", 0.01, 100.0},
    {"reversals", &Staircases::reversals, "a track ends after so many; 0: by `trials` alone", 0.0,
     1000.0},
    {"trials", &Staircases::trials, "a track ends after so many at the latest", 1.0, 10'000.0},
});

/// Empty if the method can be used; else the first bad key, with value and range.
[[nodiscard]] std::string validate(const Staircases &method);

/// The proportion of correct answers (or of "yes") to which the tracks converge, see above.
[[nodiscard]] double convergence_proportion(const Staircases &method);

[[nodiscard]] inline int max_trials(const Staircases &method) {
    return static_cast<int>(method.start_levels.size()) * method.trials;
}

/// One track so far. A reversal is a trial that steps against the step before, also where an end
/// of the levels left no room for a step.
struct StaircaseTrack {
    double level = 0.0; ///< of its next trial
    int trials = 0;
    int correct_in_a_row = 0;            ///< since the last step
    int last_step = 0;                   ///< +1 up, −1 down, 0 none yet
    std::vector<double> reversal_levels; ///< the levels at which it turned
    std::vector<int>
        reversal_directions; ///< of the steps there: +1 up (a valley), −1 down (a peak)
};

/// The method while it runs; see MethodRun.
class StaircasesRun {
public:
    StaircasesRun(const Staircases &method, RandomKey key);

    [[nodiscard]] bool is_done() const;
    [[nodiscard]] std::optional<MethodTrial> next() const;
    void add(const PastMethodTrial &trial);

    [[nodiscard]] std::span<const StaircaseTrack> tracks() const { return tracks_; }

private:
    [[nodiscard]] bool is_done(const StaircaseTrack &track) const;
    [[nodiscard]] double stepped(double level, int direction, int reversals) const;

    Staircases method_;
    RandomKey key_;
    std::vector<StaircaseTrack> tracks_;
    std::uint64_t trials_ = 0; ///< of all tracks, marked ones too
};

// QUEST+ (Watson 2017, Journal of Vision 17(3):10): each trial is presented at the level that
// leaves the least entropy to be expected of the posterior over threshold, slope, guess and lapse.

/// A prior, and the number of nodes of its grid.
struct PriorAxis {
    Prior prior;
    int points = 1;

    friend bool operator==(const PriorAxis &, const PriorAxis &) = default;
};

struct QuestPlus {
    FunctionFamily family;
    std::vector<double> levels; ///< that may be presented, rising
    PriorAxis threshold;
    PriorAxis slope;
    PriorAxis guess; ///< known in forced choice: known(1/m)
    PriorAxis lapse;
    int min_trials = 20;
    int max_trials = 60;
    /// Ends, from `min_trials` on, when the posterior's standard deviation of the threshold, on
    /// the scale of its prior, is not above this; 0: by `max_trials` alone.
    double threshold_deviation = 0.0;

    friend bool operator==(const QuestPlus &, const QuestPlus &) = default;
};

inline constexpr auto kPriorAxisFields = std::to_array<Field<PriorAxis>>({
    {"points", &PriorAxis::points,
     "of the grid over the range; without it 1, of a guess that is not known 5", 1.0, 1000.0, "",
     kDerived},
});

inline constexpr auto kQuestPlusFields = std::to_array<Field<QuestPlus>>({
    {"shape", choice_of<&QuestPlus::family, &FunctionFamily::shape>(kShapeNames),
     "of the psychometric function"},
    {"scale", choice_of<&QuestPlus::family, &FunctionFamily::scale>(kScaleNames),
     "on which it is fitted"},
    {"levels", &QuestPlus::levels, "that may be presented, rising", kTypedLevel, "", kRequired},
    {"fewest_trials", &QuestPlus::min_trials, "before it may end", 1.0, 10'000.0},
    {"most_trials", &QuestPlus::max_trials, "when it ends at the latest", 1.0, 10'000.0},
    {"threshold_deviation", &QuestPlus::threshold_deviation,
     "ends when the threshold is known to within this standard deviation, on the scale of its "
     "prior; 0: by `most_trials` alone",
     0.0, kMaxTyped},
});

[[nodiscard]] FunctionPriors priors_of(const QuestPlus &method);

/// Levels times nodes of all four grids.
[[nodiscard]] double table_cells(const QuestPlus &method);

/// Above it, not even a study that is there can be read. `check_choices` refuses new ones earlier.
inline constexpr double kMaxQuestTable = 5e6;

/// Empty if the method can be used; else the first bad key, with value and range.
[[nodiscard]] std::string validate(const QuestPlus &method);

[[nodiscard]] inline int max_trials(const QuestPlus &method) { return method.max_trials; }

/// The method while it runs; see MethodRun.
///
/// The expected entropy after a trial at level x is that of the present posterior less the mutual
/// information I(x) of answer and parameters θ, so the level with the most information is
/// presented, the lowest of several:
///
///   I(x) = h(Σ_θ p(θ) ψ(x; θ)) − Σ_θ p(θ) h(ψ(x; θ)),   h(ψ) = −ψ ln ψ − (1 − ψ) ln(1 − ψ).
///
/// With ψ and h(ψ) tabulated this is two products of a table and a vector.
class QuestPlusRun {
public:
    explicit QuestPlusRun(const QuestPlus &method);

    [[nodiscard]] bool is_done() const;
    [[nodiscard]] std::optional<MethodTrial> next() const;
    void add(const PastMethodTrial &trial);

    /// A function of the posterior, with the mean of each parameter (threshold and slope on the
    /// scale of their priors).
    [[nodiscard]] PsychometricFunction mean() const;

    /// Standard deviation of the threshold on the scale of its prior.
    [[nodiscard]] double threshold_deviation() const;

    /// Entropy of the posterior [nat].
    [[nodiscard]] double entropy() const;

    /// Entropy to be expected after a trial at each level [nat].
    [[nodiscard]] Eigen::VectorXd expected_entropy() const;

private:
    using Table = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

    [[nodiscard]] Eigen::VectorXd information() const;

    QuestPlus method_;
    std::vector<PsychometricFunction> functions_; ///< one per node of the grid
    Table proportions_;                           ///< ψ: a row per level, a column per function
    Table answer_entropies_;                      ///< h(ψ), likewise
    Eigen::VectorXd posterior_;                   ///< weights of the functions, sum 1
    int trials_ = 0;                              ///< that were not marked
};

// A method presents levels, one trial after the other, and decides when it is done. What it
// presents next is a function of its specification, a random key and its trials so far.

using Method = std::variant<ConstantStimuli, Staircases, QuestPlus, Adjustment>;

/// By the index of the method in the variant, as in protocol files.
inline constexpr std::array<std::string_view, 4> kMethodNames{"constant_stimuli", "staircases",
                                                              "quest_plus", "adjustment"};

/// Empty if the method can be used for the task; else the first bad key, with value and range.
[[nodiscard]] std::string validate(const Method &method, const Task &task);

/// An upper bound of its trials, not counting marked ones.
[[nodiscard]] int max_trials(const Method &method);

/// A method while it runs, trial by trial.
class MethodRun {
public:
    /// @pre validate(method, task) is empty
    MethodRun(const Method &method, RandomKey key);

    [[nodiscard]] bool is_done() const;

    /// The same however often it is asked; nothing when the method is done.
    [[nodiscard]] std::optional<MethodTrial> next() const;

    /// @pre not done; `trial.presented` is `next()`
    void add(const PastMethodTrial &trial);

private:
    std::variant<ConstantStimuliRun, StaircasesRun, QuestPlusRun, AdjustmentRun> run_;
};

} // namespace springdrive::study
