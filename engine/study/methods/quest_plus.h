// QUEST+ (Watson 2017, Journal of Vision 17(3):10): each trial is presented at the level that
// leaves the least entropy to be expected of the posterior over threshold, slope, guess and lapse.
#pragma once

#include "engine/study/methods/function_priors.h"
#include "engine/study/methods/prior.h"
#include "engine/study/methods/psychometric_function.h"
#include "engine/study/methods/trial.h"

#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

namespace springdrive::study {

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

/// Levels times nodes of all four grids: above it, the next level would take too long.
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

} // namespace springdrive::study
