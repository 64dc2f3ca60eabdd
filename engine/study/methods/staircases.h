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
// stationary distribution of its Markov chain says (tests/engine/study/staircases_test.cpp).
#pragma once

#include "engine/study/methods/random_key.h"
#include "engine/study/methods/scale.h"
#include "engine/study/methods/trial.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace springdrive::study {

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

} // namespace springdrive::study
