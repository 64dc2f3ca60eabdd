// Covers engine/study/analysis/student.cpp, group_summary.cpp, direct_estimates.cpp and
// goodness_of_fit.cpp.
#include "engine/study/analysis/direct_estimates.h"
#include "engine/study/analysis/goodness_of_fit.h"
#include "engine/study/analysis/group_summary.h"
#include "engine/study/analysis/student.h"
#include "tests/engine/study/references.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace springdrive::study {
namespace {

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

} // namespace
} // namespace springdrive::study
