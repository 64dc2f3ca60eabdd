// Covers engine/study/analysis/maximum_likelihood.cpp, scoring.cpp and level_counts.cpp, against
// psyphy in R (references.R) and brute force.
#include "engine/study/analysis/goodness_of_fit.h"
#include "engine/study/analysis/maximum_likelihood.h"
#include "tests/engine/study/references.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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

} // namespace
} // namespace springdrive::study
