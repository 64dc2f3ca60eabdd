// Covers engine/study/ as a whole: studies of observers that are drawn from the prior, from the
// first trial to the interval. Of 1000 studies, an interval of 95 % holds the truth in 95 ± 1.35 %.
#include "base/parallel.h"
#include "engine/study/analysis/maximum_likelihood.h"
#include "engine/study/analysis/posterior.h"
#include "engine/study/analysis/precision_plan.h"
#include "engine/study/analysis/summaries.h"
#include "tests/support/cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace springdrive::study {
namespace {

/// The observers: thresholds over a factor of eight, slopes over a factor of six.
FunctionPriors observers_of(const Prior &guess) {
    FunctionPriors priors;
    priors.family = {Shape::weibull, Scale::logarithmic};
    priors.threshold = {Scale::logarithmic, 0.5, 4.0};
    priors.slope = {Scale::logarithmic, 1.0, 6.0};
    priors.guess = guess;
    priors.lapse = {Scale::linear, 0.0, 0.06};
    return priors;
}

/// Each factor of √2 from a quarter to eight.
std::vector<double> levels_of_coverage() {
    std::vector<double> levels;
    for (int i = 0; i <= 10; ++i) {
        levels.push_back(0.25 * std::pow(2.0, 0.5 * i));
    }
    return levels;
}

/// What became of one study; errors are of ln threshold and ln slope, estimate less truth.
struct Judged {
    bool posterior_holds_threshold = false;
    bool posterior_holds_slope = false;
    bool posterior_holds_level = false; ///< at which F is 0.9
    bool profile_holds_threshold = false;
    double posterior_error = 0.0;
    double likelihood_error = 0.0;
    double posterior_slope_error = 0.0;
    double likelihood_slope_error = 0.0;
    double width = 0.0;          ///< of the posterior's interval of ln threshold
    double reversal_error = 0.0; ///< against the level of the rule's proportion
    bool has_reversals = false;
};

bool holds(const PosteriorSummary &summary, double truth) {
    return summary.low <= truth && truth <= summary.high;
}

Judged judged_study(const Method &method, const FunctionPriors &priors, RandomKey key) {
    const PsychometricFunction truth = drawn_function(priors, child(key, 0));
    const std::vector<PastMethodTrial> trials = simulated_trials(method, truth, child(key, 1));
    const std::vector<LevelCount> counts = counted(trials);
    const Posterior posterior(counts, priors);
    const PosteriorSummary threshold = posterior.of(FunctionParameter::threshold);
    const PosteriorSummary slope = posterior.of(FunctionParameter::slope);
    const LikelihoodFit fit = maximum_likelihood(counts, priors);
    const ProfileInterval profile = profile_interval(counts, priors, FunctionParameter::threshold);
    Judged judged;
    judged.posterior_holds_threshold = holds(threshold, truth.threshold);
    judged.posterior_holds_slope = holds(slope, truth.slope);
    judged.posterior_holds_level = holds(posterior.of_level_at(0.9), level_at_core(truth, 0.9));
    judged.profile_holds_threshold =
        profile.low <= truth.threshold && truth.threshold <= profile.high;
    judged.posterior_error = std::log(threshold.mean / truth.threshold);
    judged.likelihood_error = std::log(fit.function.threshold / truth.threshold);
    judged.posterior_slope_error = std::log(slope.mean / truth.slope);
    judged.likelihood_slope_error = std::log(fit.function.slope / truth.slope);
    judged.width = std::log(threshold.high / threshold.low);
    if (const auto *staircases = std::get_if<Staircases>(&method)) {
        // Of an observer who lapses more than the rule asks for there is no such level.
        const std::optional<double> target = level_at(truth, convergence_proportion(*staircases));
        double sum = 0.0;
        int tracks = 0;
        for (const auto &estimate : reversal_estimates(*staircases, trials, 4)) {
            sum += estimate ? std::log(estimate->level) : 0.0;
            tracks += estimate ? 1 : 0;
        }
        judged.has_reversals = target && tracks > 0;
        judged.reversal_error = judged.has_reversals ? sum / tracks - std::log(*target) : 0.0;
    }
    return judged;
}

double share_of(const std::vector<Judged> &studies, bool Judged::*holds_it) {
    return static_cast<double>(std::ranges::count(studies, true, holds_it)) /
           static_cast<double>(studies.size());
}

double mean_of_studies(const std::vector<Judged> &studies, double Judged::*value) {
    double sum = 0.0;
    for (const Judged &study : studies) {
        sum += study.*value / static_cast<double>(studies.size());
    }
    return sum;
}

/// 93 to 97 % of 1000; of a sample and of many more, four deviations of its count.
void expect_covered(double share, std::size_t studies) {
    const double four_deviations = 4.0 * std::sqrt(0.95 * 0.05 / static_cast<double>(studies));
    const double tolerance = studies >= 1000 ? std::min(0.02, four_deviations) : four_deviations;
    EXPECT_NEAR(share, 0.95, tolerance);
}

std::vector<Judged> judged_studies(const std::string &name, const Method &method, const Task &task,
                                   const FunctionPriors &priors, std::uint64_t seed) {
    EXPECT_EQ(validate(method, task), "");
    std::vector<Judged> studies(static_cast<std::size_t>(testing::cases(60, 1000)));
    for_each_in_parallel(studies.size(), all_processors(), [&](std::size_t i) {
        studies[i] = judged_study(method, priors, key_of(seed, static_cast<int>(i)));
    });
    const double threshold = share_of(studies, &Judged::posterior_holds_threshold);
    const double slope = share_of(studies, &Judged::posterior_holds_slope);
    const double level = share_of(studies, &Judged::posterior_holds_level);
    const double profile = share_of(studies, &Judged::profile_holds_threshold);
    std::printf("counts: %s, %d trials: posterior holds threshold %.1f %%, slope %.1f %%, "
                "90 %% level %.1f %%, profile likelihood holds threshold %.1f %%; bias of "
                "ln threshold %.3f by posterior, %.3f by likelihood, of ln slope %.3f and %.3f; "
                "width %.2f\n",
                name.c_str(), max_trials(method), 100.0 * threshold, 100.0 * slope, 100.0 * level,
                100.0 * profile, mean_of_studies(studies, &Judged::posterior_error),
                mean_of_studies(studies, &Judged::likelihood_error),
                mean_of_studies(studies, &Judged::posterior_slope_error),
                mean_of_studies(studies, &Judged::likelihood_slope_error),
                mean_of_studies(studies, &Judged::width));
    expect_covered(threshold, studies.size());
    expect_covered(slope, studies.size());
    expect_covered(level, studies.size());
    EXPECT_GT(profile, 0.85); // asymptotic: reported
    return studies;
}

TEST(StudyCoverage, OfConstantStimuli) {
    static_cast<void>(judged_studies("constant stimuli",
                                     ConstantStimuli{levels_of_coverage(), 1, 12}, Task{},
                                     observers_of(known(0.5)), 1));
}

TEST(StudyCoverage, OfConstantStimuliWithYesAndNo) {
    std::vector<double> levels = levels_of_coverage();
    levels.insert(levels.begin(), 0.0); // no stimulus: what is answered are false alarms
    static_cast<void>(judged_studies("constant stimuli, yes/no", ConstantStimuli{levels, 1, 10},
                                     Task{TaskKind::yes_no, 2, 0.3},
                                     observers_of({Scale::linear, 0.0, 0.3}), 2));
}

TEST(StudyCoverage, OfStaircases) {
    Staircases method;
    method.scale = Scale::logarithmic;
    method.start_levels = {8.0, 2.0};
    method.minimum_level = 0.25;
    method.maximum_level = 8.0;
    method.correct_for_down = 3;
    method.steps = {{0, 2.0}, {2, std::sqrt(2.0)}};
    method.reversals = 0;
    method.trials = 60;
    const std::vector<Judged> studies =
        judged_studies("3-down-1-up staircases", method, Task{}, observers_of(known(0.5)), 3);
    double sum = 0.0;
    int with_reversals = 0;
    for (const Judged &study : studies) {
        sum += study.reversal_error;
        with_reversals += study.has_reversals ? 1 : 0;
    }
    std::printf("counts: mean of reversals less level of 79.4 %% correct: ln ratio %.3f\n",
                sum / with_reversals);
    EXPECT_GT(with_reversals, 50);
}

TEST(StudyCoverage, OfQuestPlus) {
    const FunctionPriors priors = observers_of(known(0.5));
    QuestPlus method;
    method.family = priors.family;
    method.levels = levels_of_coverage();
    method.threshold = {priors.threshold, 30};
    method.slope = {priors.slope, 10};
    method.guess = {priors.guess, 1};
    method.lapse = {priors.lapse, 3};
    method.max_trials = 60;
    static_cast<void>(judged_studies("QUEST+", method, Task{}, priors, 4));
}

TEST(StudyCoverage, OfAdjustments) {
    const FunctionPriors priors = observers_of(known(0.0));
    const Adjustment method{Scale::logarithmic, 0.5, 4.0, 0.01, 100.0, 8};
    const int studies = testing::cases(60, 20'000); // they cost little
    int held = 0;
    int held_of_1000 = 0;
    for (int i = 0; i < studies; ++i) {
        const RandomKey key = key_of(5, i);
        const PsychometricFunction truth = drawn_function(priors, child(key, 0));
        const MeanSummary mean =
            settings_on_scale(method, simulated_trials(method, truth, child(key, 1))).value();
        held += mean.low <= std::log(truth.threshold) && std::log(truth.threshold) <= mean.high;
        held_of_1000 = i < 1000 ? held : held_of_1000;
    }
    const double share = held / static_cast<double>(studies);
    std::printf("counts: adjustments, 8 settings: Student's interval holds %.1f %% of %d, %.1f %% "
                "of the first %d\n",
                100.0 * share, studies, 100.0 * held_of_1000 / std::min(studies, 1000),
                std::min(studies, 1000));
    expect_covered(share, static_cast<std::size_t>(studies));
}

} // namespace
} // namespace springdrive::study
