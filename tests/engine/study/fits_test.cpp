// Covers engine/study/analysis/{maximum_likelihood,summaries,precision_plan}.cpp, against psyphy
// and metafor in R (references.R) and brute force.
#include "engine/study/analysis/maximum_likelihood.h"
#include "engine/study/analysis/precision_plan.h"
#include "engine/study/analysis/summaries.h"
#include "tests/engine/study/references.h"
#include "tests/engine/study/refusals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace springdrive::study {
namespace {

Prior between(const std::array<double, 2> &range) {
    Prior prior;
    prior.minimum = range[0];
    prior.maximum = range[1];
    return prior;
}

std::vector<double> levels_of(const std::vector<LevelCount> &counts) {
    std::vector<double> levels;
    for (const LevelCount &count : counts) {
        levels.push_back(count.level);
    }
    return levels;
}

FunctionPriors priors_for(const PsyphyFit &reference) {
    FunctionPriors priors = usual_priors(reference.family, Task{}, levels_of(reference.counts));
    priors.guess = between(reference.guess_range);
    priors.lapse = between(reference.lapse_range);
    return priors;
}

const PsyphyFit &reference_named(const std::string &name) {
    return *std::ranges::find(kPsyphyFits, name, &PsyphyFit::name);
}

TEST(MaximumLikelihood, AgreesWithPsyphy) {
    for (const PsyphyFit &reference : kPsyphyFits) {
        const LikelihoodFit fit = maximum_likelihood(reference.counts, priors_for(reference));
        // Near a maximum, parameters are known to the root of what its height is known to. R's
        // search of both rates stops some 1e-9 of the deviance short of it, one of given rates at
        // the last bits.
        const bool are_given = !std::isnan(reference.threshold_low);
        const double tolerance = are_given ? 1e-7 : 3e-4;
        EXPECT_NEAR(fit.function.threshold, reference.threshold, tolerance) << reference.name;
        EXPECT_NEAR(fit.function.slope, reference.slope, tolerance * reference.slope)
            << reference.name;
        EXPECT_NEAR(fit.function.guess, reference.guess, tolerance) << reference.name;
        EXPECT_NEAR(fit.function.lapse, reference.lapse, tolerance) << reference.name;
        const double reached = deviance(fit.function, reference.counts);
        EXPECT_NEAR(reached, reference.deviance, are_given ? 1e-10 : 1e-6) << reference.name;
        EXPECT_LT(reached, reference.deviance + 1e-9) << reference.name;
    }
}

TEST(MaximumLikelihood, ProfileIntervalsAgreeWithPsyphy) {
    int compared = 0;
    for (const PsyphyFit &reference : kPsyphyFits) {
        if (std::isnan(reference.threshold_low)) {
            continue;
        }
        const ProfileInterval interval =
            profile_interval(reference.counts, priors_for(reference), FunctionParameter::threshold);
        EXPECT_NEAR(interval.low, reference.threshold_low, 1e-6) << reference.name;
        EXPECT_NEAR(interval.high, reference.threshold_high, 1e-6) << reference.name;
        EXPECT_FALSE(interval.is_low_open || interval.is_high_open);
        ++compared;
    }
    EXPECT_EQ(compared, 5);
}

/// Brute force: the largest likelihood over dense grids of the ranges of slope and lapse, with the
/// level at which F is `core` held at x.
double brute_profile(const PsyphyFit &reference, double core, double x) {
    double best = -1e300;
    const double z = core_argument(reference.family.shape, core);
    for (int i = 0; i <= 400; ++i) {
        const double slope = (0.5 / std::log(32.0)) * std::pow(100.0, i / 400.0);
        for (int j = 0; j <= 100; ++j) {
            PsychometricFunction function{reference.family, x * std::exp(-z / slope), slope, 0.5,
                                          0.001 * j};
            best = std::max(best, log_likelihood(function, reference.counts));
        }
    }
    return best;
}

TEST(MaximumLikelihood, ProfileIntervalsOfAnyLevelAreThoseOfBruteForce) {
    const PsyphyFit &reference = reference_named("weibull, two alternatives, lapses fitted");
    const FunctionPriors priors = priors_for(reference);
    const double highest = maximum_likelihood(reference.counts, priors).log_likelihood;
    for (const double core : {0.3, core_at_threshold(Shape::weibull), 0.9}) {
        const ProfileInterval interval = profile_interval_at(reference.counts, priors, core);
        for (const double end : {interval.low, interval.high}) {
            // χ² 0.95: 3.8415; the grid misses the maximum by some 1e-4.
            EXPECT_NEAR(2.0 * (highest - brute_profile(reference, core, end)), 3.8415, 1e-3);
        }
        EXPECT_LT(interval.low, interval.high);
    }
}

TEST(MaximumLikelihood, IntervalsOfRatesMayBeOpen) {
    const PsyphyFit &reference = reference_named("weibull, two alternatives, lapses fitted");
    const FunctionPriors priors = priors_for(reference);
    const ProfileInterval lapse =
        profile_interval(reference.counts, priors, FunctionParameter::lapse);
    EXPECT_GT(lapse.low, 0.0); // 115 of 120 correct at the three highest levels
    EXPECT_FALSE(lapse.is_low_open);
    EXPECT_EQ(lapse.high, 0.1);
    EXPECT_TRUE(lapse.is_high_open);
    const LikelihoodFit fit = maximum_likelihood(reference.counts, priors);
    EXPECT_EQ(fit.free_parameters, 3);
    const ProfileInterval slope =
        profile_interval(reference.counts, priors, FunctionParameter::slope);
    EXPECT_LT(slope.low, fit.function.slope);
    EXPECT_GT(slope.high, fit.function.slope);
}

TEST(MaximumLikelihood, SaysWhenTheTrialsDoNotTellAParameter) {
    const FunctionFamily family{Shape::logistic, Scale::linear};
    FunctionPriors priors =
        usual_priors(family, {TaskKind::yes_no, 2, 0.0}, std::vector{0.0, 1.0, 2.0, 3.0});
    priors.lapse = known(0.0);
    // A step between two levels: no slope is steep enough.
    const std::vector<LevelCount> step{{0.0, 0, 20}, {1.0, 0, 20}, {2.0, 20, 20}, {3.0, 20, 20}};
    LikelihoodFit fit = maximum_likelihood(step, priors);
    EXPECT_TRUE(fit.is_at_end[1]);
    EXPECT_GT(fit.function.threshold, 1.0);
    EXPECT_LT(fit.function.threshold, 2.0);
    EXPECT_TRUE(profile_interval(step, priors, FunctionParameter::slope).is_high_open);
    // All positive: the threshold is below all levels.
    const std::vector<LevelCount> all{{0.0, 20, 20}, {1.0, 20, 20}, {2.0, 20, 20}, {3.0, 20, 20}};
    fit = maximum_likelihood(all, priors);
    const ProfileInterval threshold = profile_interval(all, priors, FunctionParameter::threshold);
    EXPECT_TRUE(threshold.is_low_open);
    EXPECT_FALSE(threshold.is_high_open);
    EXPECT_LT(threshold.high, 0.0);
    EXPECT_TRUE(std::isfinite(fit.log_likelihood));
    EXPECT_NEAR(fit.log_likelihood, 0.0, 1e-6);
}

TEST(LevelCounts, LeaveMarkedTrialsOutAndSortLevels) {
    const std::vector<PastMethodTrial> trials{{{2.0, 0}, {true, 0.0, false}},
                                              {{1.0, 1}, {false, 0.0, false}},
                                              {{2.0, 1}, {false, 0.0, false}},
                                              {{1.0, 0}, {true, 0.0, true}}};
    EXPECT_EQ(counted(trials), (std::vector<LevelCount>{{1.0, 0, 1}, {2.0, 1, 2}}));
}

TEST(LevelCounts, LikelihoodIsThatOfEachAnswer) {
    const PsychometricFunction function{{Shape::logistic, Scale::linear}, 1.0, 2.0, 0.5, 0.02};
    const double p = 0.5 + 0.48 / (1.0 + std::exp(-2.0));
    EXPECT_NEAR(log_likelihood(function, std::vector<LevelCount>{{2.0, 3, 5}}),
                std::log(p * p * p * (1.0 - p) * (1.0 - p)), 1e-13);
}

TEST(Student, HasTheTabulatedQuantiles) {
    // Abramowitz & Stegun (1964), table 26.10: A(t|ν) = 0.95 and 0.99.
    for (const auto &[degrees, t95, t99] : {std::tuple{1, 12.706, 63.657},
                                            {2, 4.303, 9.925},
                                            {3, 3.182, 5.841},
                                            {10, 2.228, 3.169},
                                            {29, 2.045, 2.756},
                                            {120, 1.980, 2.617}}) {
        EXPECT_NEAR(student_quantile(0.975, degrees), t95, 5.1e-4);
        EXPECT_NEAR(student_quantile(0.995, degrees), t99, 5.1e-4);
    }
    EXPECT_NEAR(student_proportion(-1.0, 1), 0.25, 1e-14); // Cauchy's
    EXPECT_NEAR(student_proportion(1.0, 1), 0.75, 1e-14);
}

TEST(Student, MeanHasItsInterval) {
    const MeanSummary mean = mean_of(std::vector{1.0, 2.0, 6.0});
    EXPECT_NEAR(mean.mean, 3.0, 1e-15);
    EXPECT_NEAR(mean.deviation, std::sqrt(7.0), 1e-15);
    EXPECT_NEAR(mean.high, 3.0 + 4.302653 * std::sqrt(7.0 / 3.0), 1e-5);
    EXPECT_NEAR(mean.low, 6.0 - mean.high, 1e-12);
    const MeanSummary one = mean_of(std::vector{1.0});
    EXPECT_EQ(one.mean, 1.0);
    EXPECT_TRUE(std::isinf(one.low) && std::isinf(one.high));
}

TEST(Groups, RandomEffectsAreThoseOfMetafor) {
    for (const MetaforGroup &reference : kMetaforGroups) {
        const GroupSummary group = random_effects(reference.estimates);
        EXPECT_NEAR(group.mean, reference.mean, 1e-9);
        EXPECT_NEAR(group.standard_error, reference.standard_error, 1e-9);
        EXPECT_NEAR(group.low, reference.low, 1e-8);
        EXPECT_NEAR(group.high, reference.high, 1e-8);
        EXPECT_NEAR(group.deviation_between, reference.deviation_between, 1e-9);
        EXPECT_NEAR(group.heterogeneity, reference.heterogeneity, 1e-9);
    }
}

TEST(Groups, OfOneParticipantKnowNothingOfOthers) {
    const GroupSummary group = random_effects(std::vector<ParticipantEstimate>{{2.0, 0.3}});
    EXPECT_EQ(group.mean, 2.0);
    EXPECT_EQ(group.deviation_between, 0.0);
    EXPECT_TRUE(std::isinf(group.low) && std::isinf(group.high));
}

TEST(DirectEstimates, AverageAnEvenNumberOfTheLastReversals) {
    Staircases method;
    method.maximum_level = 100.0;
    method.start_levels = {10.0, 50.0};
    method.correct_for_down = 1;
    method.steps = {{0, 1.0}};
    // Track 0 turns at 8 (valley), 9 (peak), 7 (valley), 8 (peak); track 1 not at all.
    StaircasesRun run(method, {});
    std::vector<PastMethodTrial> trials;
    for (const bool correct : {true, true, false, true, true, false, true}) {
        trials.push_back({{run.tracks()[0].level, 0}, {correct, 0.0, false}});
        run.add(trials.back());
    }
    trials.push_back({{50.0, 1}, {true, 0.0, false}});
    EXPECT_EQ(run.tracks()[0].reversal_levels, (std::vector{8.0, 9.0, 7.0, 8.0}));
    const auto all = reversal_estimates(method, trials, 0);
    ASSERT_EQ(all.size(), 2U);
    EXPECT_EQ(all[0]->level, 8.0);
    EXPECT_EQ(all[0]->reversals, 4);
    EXPECT_FALSE(all[1].has_value());
    const auto later = reversal_estimates(method, trials, 1);
    EXPECT_EQ(later[0]->level, 7.5);
    EXPECT_EQ(later[0]->reversals, 2);
    EXPECT_FALSE(reversal_estimates(method, trials, 3)[0].has_value());
}

TEST(DirectEstimates, AverageSettingsOnTheirScale) {
    Adjustment method;
    method.scale = Scale::logarithmic;
    const std::vector<PastMethodTrial> trials{{{1.0, 0}, {false, 2.0, false}},
                                              {{1.0, 0}, {false, 999.0, true}},
                                              {{1.0, 0}, {false, 8.0, false}}};
    EXPECT_NEAR(settings_on_scale(method, trials)->mean, std::log(4.0), 1e-15);
    EXPECT_EQ(settings_on_scale(method, trials)->values, 2);
    EXPECT_FALSE(settings_on_scale(method, {}).has_value());
    EXPECT_NEAR(weber_fraction(1.25, 1.0), 0.25, 1e-15);
}

/// Two alternatives at six levels.
const PsychometricFunction kWell{{Shape::weibull, Scale::logarithmic}, 1.5, 2.0, 0.5, 0.02};
const std::vector<LevelCount> kDesign{{0.25, 0, 30}, {0.5, 0, 30}, {1.0, 0, 30},
                                      {2.0, 0, 30},  {4.0, 0, 30}, {8.0, 0, 30}};

FunctionPriors well_priors() {
    return usual_priors(kWell.family, Task{}, std::vector{0.25, 0.5, 1.0, 2.0, 4.0, 8.0});
}

GoodnessOfFit goodness_of(const std::vector<LevelCount> &counts, std::uint64_t number) {
    return goodness_of_fit(maximum_likelihood(counts, well_priors()), counts, well_priors(),
                           child({12}, number), 39);
}

TEST(GoodnessOfFit, RejectsAsManyTrueFunctionsAsItSays) {
    constexpr int kStudies = 100;
    int rejected = 0;
    int below_half = 0;
    double dispersion = 0.0;
    for (std::uint64_t i = 0; i < kStudies; ++i) {
        const GoodnessOfFit goodness =
            goodness_of(simulated_counts(kWell, kDesign, child({13}, i)), i);
        EXPECT_EQ(goodness.degrees_of_freedom, 3);
        rejected += goodness.p_value <= 0.05 ? 1 : 0;
        below_half += goodness.p_value <= 0.5 ? 1 : 0;
        dispersion += goodness.dispersion / kStudies;
    }
    // 4 deviations of binomial counts: 5 ± 2.2 and 50 ± 5.
    EXPECT_NEAR(rejected, 5, 8.8);
    EXPECT_NEAR(below_half, 50, 20);
    EXPECT_NEAR(dispersion, 1.0, 4.0 * std::sqrt(2.0 / 3.0 / kStudies) + 0.1); // bounds cost some
}

TEST(GoodnessOfFit, RejectsAnswersThatScatterMoreThanTrialsDo) {
    // Each level of each study has a threshold of its own, off by a factor of up to four.
    int rejected = 0;
    double dispersion = 0.0;
    for (std::uint64_t i = 0; i < 20; ++i) {
        std::vector<LevelCount> counts;
        for (std::size_t level = 0; level < kDesign.size(); ++level) {
            const RandomKey key = child(child({14}, i), level);
            PsychometricFunction drifted = kWell;
            drifted.threshold *= std::pow(4.0, 2.0 * uniform(key) - 1.0);
            counts.push_back(
                simulated_counts(drifted, std::span(kDesign).subspan(level, 1), child(key, 1))[0]);
        }
        const GoodnessOfFit goodness = goodness_of(counts, i);
        rejected += goodness.p_value <= 0.05 ? 1 : 0;
        dispersion += goodness.dispersion / 20.0;
    }
    EXPECT_GE(rejected, 4); // 1 if they were independent trials
    EXPECT_GT(dispersion, 1.5);
}

TEST(GoodnessOfFit, DevianceIsZeroOfAFunctionThroughAllPoints) {
    const PsychometricFunction function{{Shape::logistic, Scale::linear}, 0.0, 1.0, 0.0, 0.0};
    EXPECT_NEAR(deviance(function, std::vector<LevelCount>{{0.0, 5, 10}, {std::log(4.0), 8, 10}}),
                0.0, 1e-13);
    EXPECT_NEAR(deviance(function, std::vector<LevelCount>{{0.0, 10, 10}}), 20.0 * std::log(2.0),
                1e-12);
}

PrecisionQuestion question_of_constant_stimuli() {
    PrecisionQuestion question;
    question.method = ConstantStimuli{{0.25, 0.5, 1.0, 2.0, 4.0}, 1, 10};
    question.analysis.threshold = {Scale::logarithmic, 0.1, 10.0};
    question.analysis.slope = {Scale::logarithmic, 0.5, 8.0};
    question.analysis.guess = known(0.5);
    question.analysis.lapse = {Scale::linear, 0.0, 0.06};
    question.observers = question.analysis;
    question.observers.threshold = known(1.0);
    question.observers.threshold.scale = Scale::logarithmic;
    question.observers.slope = known(2.5);
    question.observers.lapse = known(0.02);
    question.trials = {50, 200, 800};
    question.studies = 40;
    return question;
}

TEST(SimulatedStudy, AnswersAsTheFunctionSays) {
    const PsychometricFunction observer{
        {Shape::logistic, Scale::logarithmic}, 2.0, 3.0, 0.25, 0.05};
    constexpr int kTrials = 20'000;
    int positive = 0;
    std::vector<double> settings;
    for (std::uint64_t i = 0; i < kTrials; ++i) {
        const Outcome outcome = answer_of(observer, 2.5, child({21}, i));
        positive += outcome.positive ? 1 : 0;
        settings.push_back(std::log(outcome.setting));
        EXPECT_FALSE(outcome.marked);
    }
    const double p = proportion_at(observer, 2.5);
    EXPECT_NEAR(positive, kTrials * p, 4.0 * std::sqrt(kTrials * p * (1.0 - p)));
    const MeanSummary mean = mean_of(settings);
    EXPECT_NEAR(mean.mean, std::log(2.0), 4.0 * mean.standard_error);
    // The deviation of a deviation is σ/√(2n).
    EXPECT_NEAR(mean.deviation, 1.0 / 3.0, 4.0 / 3.0 / std::sqrt(2.0 * kTrials));
}

TEST(Precision, GrowsWithTheRootOfTheTrials) {
    const std::vector<Precision> rows = precision_by_trials(question_of_constant_stimuli());
    ASSERT_EQ(rows.size(), 3U);
    EXPECT_EQ(rows[1].trials, 200);
    // Of a known slope the width is exactly inverse to the root; the prior's end cuts the first.
    EXPECT_NEAR(rows[1].median_width / rows[2].median_width, 2.0, 0.3);
    EXPECT_GT(rows[0].median_width, 1.3 * rows[1].median_width);
    for (const Precision &row : rows) {
        EXPECT_GE(row.width_of_most, row.median_width);
        EXPECT_GE(row.coverage, 0.8); // of 40 studies, 95 % expected: below by chance once in 3000
        EXPECT_LT(std::abs(row.bias), row.rms_error);
    }
    EXPECT_LT(rows[2].rms_error, 0.5 * rows[0].rms_error);
}

TEST(Precision, OfAnAdjustmentIsStudentsInterval) {
    PrecisionQuestion question = question_of_constant_stimuli();
    question.method = Adjustment{Scale::logarithmic, 0.5, 2.0, 0.01, 100.0, 10};
    question.trials = {5, 20};
    question.studies = 400;
    const std::vector<Precision> rows = precision_by_trials(question);
    // 2 t(0.975; 4)/√5 σ and 2 t(0.975; 19)/√20 σ with σ 0.4, in the median: the sample's deviation
    // is 0.916 and 0.983 σ there.
    EXPECT_NEAR(rows[0].median_width, 2.0 * 2.7764 * 0.916 * 0.4 / std::sqrt(5.0), 0.07);
    EXPECT_NEAR(rows[1].median_width, 2.0 * 2.0930 * 0.983 * 0.4 / std::sqrt(20.0), 0.02);
    EXPECT_NEAR(rows[0].coverage, 0.95, 0.044); // 4 deviations
    EXPECT_NEAR(rows[1].coverage, 0.95, 0.044);
}

TEST(Precision, FindsTheTrialsForAWidth) {
    std::vector<Precision> rows(3);
    rows[0] = {50, 0.0, 0.8, 0.0, 0.0, 0.0};
    rows[1] = {200, 0.0, 0.4, 0.0, 0.0, 0.0};
    rows[2] = {800, 0.0, 0.2, 0.0, 0.0, 0.0};
    EXPECT_EQ(trials_for_width(rows, 0.9), 50.0);
    EXPECT_NEAR(trials_for_width(rows, 0.6).value(), 100.0, 1e-9); // halfway in ln trials
    EXPECT_NEAR(trials_for_width(rows, 0.2).value(), 800.0, 1e-9);
    EXPECT_FALSE(trials_for_width(rows, 0.19).has_value());
}

TEST(Precision, GivesEachMethodItsTrials) {
    EXPECT_EQ(max_trials(with_trials(ConstantStimuli{{1.0, 2.0, 3.0}, 2, 1}, 13)), 18);
    Staircases staircases;
    staircases.start_levels = {1.0, 0.0};
    staircases.steps = {{0, 0.1}};
    EXPECT_EQ(max_trials(with_trials(staircases, 31)), 32);
    EXPECT_EQ(std::get<Staircases>(with_trials(staircases, 31)).reversals, 0);
    QuestPlus quest;
    quest.threshold_deviation = 1.0;
    EXPECT_EQ(max_trials(with_trials(quest, 31)), 31);
    EXPECT_EQ(std::get<QuestPlus>(with_trials(quest, 31)).threshold_deviation, 0.0);
    EXPECT_EQ(max_trials(with_trials(Adjustment{}, 31)), 31);
}

TEST(Precision, SaysWhatIsWrongWithTheQuestion) {
    const auto error = [](const auto &change) {
        return validate(testing::spoilt(question_of_constant_stimuli(), change), Task{});
    };
    using Q = PrecisionQuestion;
    testing::expect_refusals({
        {error([](Q &) {}), ""},
        {error([](Q &q) { q.trials.assign(2, 50); }), "trials has 50 after 50"},
        {error([](Q &q) { q.trials = {1}; }), "trials (each) is 1; it must be from 2 to 10000"},
        {error([](Q &q) { q.analysis.slope.minimum = 0.0; }), "slope.minimum is 0; it must be"},
    });
}

} // namespace
} // namespace springdrive::study
