// Covers engine/study/methods/quest_plus.cpp, against a reference that follows Watson (2017) word
// by word: the posterior from all trials anew, the entropies of both posteriors after each possible
// answer, weighted by the probability of the answer. It shares nothing but the specification.
#include "engine/study/methods/quest_plus.h"

#include "engine/study/methods/random_key.h"
#include "tests/bench/stopwatch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace springdrive::study {
namespace {

struct AnsweredLevel {
    double level = 0.0;
    bool positive = false;
};

/// ψ written out for one family each.
double reference_proportion(const FunctionFamily &family, double x, double threshold, double slope,
                            double guess, double lapse) {
    double core = 0.0;
    if (family.shape == Shape::weibull && family.scale == Scale::logarithmic) {
        core = 1.0 - std::exp(-std::pow(x / threshold, slope));
    } else if (family.shape == Shape::logistic && family.scale == Scale::linear) {
        core = 0.5 * (1.0 + std::tanh(0.5 * slope * (x - threshold)));
    } else if (family.shape == Shape::cumulative_normal && family.scale == Scale::linear) {
        core = 0.5 + 0.5 * std::erf(slope * (x - threshold) / std::sqrt(2.0));
    } else {
        ADD_FAILURE() << "no reference";
    }
    return guess + (1.0 - guess - lapse) * core;
}

/// The nodes and weights of the midpoint rule on a uniform prior.
std::vector<double> reference_nodes(const PriorAxis &axis) {
    std::vector<double> nodes;
    for (int i = 0; i < axis.points; ++i) {
        const double share = (i + 0.5) / axis.points;
        const Prior &prior = axis.prior;
        nodes.push_back(prior.scale == Scale::linear
                            ? prior.minimum + share * (prior.maximum - prior.minimum)
                            : prior.minimum * std::pow(prior.maximum / prior.minimum, share));
    }
    return nodes;
}

struct Reference {
    std::vector<std::vector<double>> by_level; ///< ψ of every node, for each level
    std::vector<double> posterior;
};

Reference reference_of(const QuestPlus &method, const std::vector<AnsweredLevel> &trials) {
    Reference reference;
    reference.by_level.resize(method.levels.size());
    for (const double threshold : reference_nodes(method.threshold)) {
        for (const double slope : reference_nodes(method.slope)) {
            for (const double guess : reference_nodes(method.guess)) {
                for (const double lapse : reference_nodes(method.lapse)) {
                    double weight = 1.0;
                    for (const AnsweredLevel &trial : trials) {
                        const double psi = reference_proportion(method.family, trial.level,
                                                                threshold, slope, guess, lapse);
                        weight *= trial.positive ? psi : 1.0 - psi;
                    }
                    reference.posterior.push_back(weight);
                    for (std::size_t i = 0; i < method.levels.size(); ++i) {
                        reference.by_level[i].push_back(reference_proportion(
                            method.family, method.levels[i], threshold, slope, guess, lapse));
                    }
                }
            }
        }
    }
    const double sum = std::accumulate(reference.posterior.begin(), reference.posterior.end(), 0.0);
    for (double &weight : reference.posterior) {
        weight /= sum;
    }
    return reference;
}

/// Watson's expected entropy of a trial at one level.
double reference_expected_entropy(const Reference &reference, std::size_t level) {
    double expected = 0.0;
    for (const bool positive : {false, true}) {
        std::vector<double> after;
        for (std::size_t j = 0; j < reference.posterior.size(); ++j) {
            const double psi = reference.by_level[level][j];
            after.push_back(reference.posterior[j] * (positive ? psi : 1.0 - psi));
        }
        const double probability = std::accumulate(after.begin(), after.end(), 0.0);
        double entropy = 0.0;
        for (const double weight : after) {
            const double p = weight / probability;
            entropy -= p > 0.0 ? p * std::log(p) : 0.0;
        }
        expected += probability * entropy;
    }
    return expected;
}

std::vector<double> spaced_levels(double first, double last, int count) {
    std::vector<double> levels;
    for (int i = 0; i < count; ++i) {
        levels.push_back(first + (last - first) * i / (count - 1));
    }
    return levels;
}

QuestPlus small_quest(Shape shape, Scale scale) {
    QuestPlus method;
    method.family = {shape, scale};
    method.levels = spaced_levels(0.25, 8.0, 16);
    method.threshold = {{scale, 0.5, 6.0}, 15};
    method.slope = {{Scale::logarithmic, 1.0, 6.0}, 7};
    method.guess = {known(0.5), 1};
    method.lapse = {{Scale::linear, 0.0, 0.08}, 3};
    method.min_trials = 5;
    method.max_trials = 40;
    return method;
}

QuestPlus small_yes_no_quest() {
    QuestPlus method = small_quest(Shape::cumulative_normal, Scale::linear);
    method.guess = {{Scale::linear, 0.0, 0.3}, 3};
    return method;
}

TEST(QuestPlus, ExpectsTheEntropiesOfAPlainReferenceToRoundOff) {
    for (const QuestPlus &method :
         {small_quest(Shape::weibull, Scale::logarithmic),
          small_quest(Shape::logistic, Scale::linear), small_yes_no_quest()}) {
        ASSERT_EQ(validate(method), "");
        QuestPlusRun run(method);
        std::vector<AnsweredLevel> trials;
        double largest_difference = 0.0;
        for (int i = 0; i < method.max_trials; ++i) {
            const Reference reference = reference_of(method, trials);
            const Eigen::VectorXd expected = run.expected_entropy();
            std::size_t least = 0;
            std::vector<double> entropies;
            for (std::size_t level = 0; level < method.levels.size(); ++level) {
                entropies.push_back(reference_expected_entropy(reference, level));
                least = entropies[level] < entropies[least] ? level : least;
                largest_difference = std::max(
                    largest_difference,
                    std::abs(entropies[level] - expected[static_cast<Eigen::Index>(level)]));
            }
            const MethodTrial trial = run.next().value();
            EXPECT_EQ(trial.level, method.levels[least]) << i;
            const bool positive =
                uniform(child({3}, static_cast<std::uint64_t>(i))) <
                reference_proportion(method.family, trial.level, 2.0, 3.0, 0.5, 0.02);
            run.add({trial, {positive, 0.0, false}});
            trials.push_back({trial.level, positive});
        }
        // Sums of N nodes of a total H: N ε H at the worst, 900 × 2.2e-16 × 6.8.
        EXPECT_LT(largest_difference, 1.4e-12);
        EXPECT_GT(largest_difference, 0.0); // two computations
        EXPECT_TRUE(run.is_done());
    }
}

TEST(QuestPlus, EndsByTheDeviationOfItsThreshold) {
    QuestPlus method = small_quest(Shape::weibull, Scale::logarithmic);
    method.max_trials = 1000;
    method.threshold_deviation = 0.15; // a ratio of 1.16
    QuestPlusRun run(method);
    int trials = 0;
    double before = 0.0;
    for (; !run.is_done(); ++trials) {
        before = run.threshold_deviation();
        const MethodTrial trial = run.next().value();
        const PsychometricFunction truth{method.family, 2.0, 3.0, 0.5, 0.02};
        run.add({trial,
                 {uniform(child({4}, static_cast<std::uint64_t>(trials))) <
                      proportion_at(truth, trial.level),
                  0.0, false}});
    }
    EXPECT_GT(trials, method.min_trials);
    EXPECT_GT(before, 0.15);
    EXPECT_LE(run.threshold_deviation(), 0.15);
    EXPECT_NEAR(std::log(run.mean().threshold / 2.0), 0.0, 3.0 * 0.15);
}

TEST(QuestPlus, StaysANumberWhenNoFunctionAllowsAnAnswer) {
    QuestPlus method = small_quest(Shape::weibull, Scale::logarithmic);
    method.levels = {0.001, 1e6};
    method.lapse = {known(0.0), 1};
    QuestPlusRun run(method);
    const double before = run.entropy();
    run.add({{1e6, 0}, {false, 0.0, false}}); // with certainty impossible
    EXPECT_NEAR(run.entropy(), before, 1e-9);
    EXPECT_TRUE(run.next().has_value());
}

TEST(QuestPlus, ChoosesFromAUsualGridWithinAMillisecondOrSo) {
    QuestPlus method = small_quest(Shape::weibull, Scale::logarithmic);
    method.levels = spaced_levels(0.2, 8.0, 40);
    method.threshold.points = 40;
    method.slope.points = 15;
    method.lapse.points = 5;
    QuestPlusRun run(method);
    double min_ns = std::numeric_limits<double>::max();
    for (int i = 0; i < 20; ++i) {
        min_ns = std::min(min_ns, bench::time_ns([&] { EXPECT_TRUE(run.next().has_value()); }));
    }
    std::printf("next level from 40 levels and 3000 functions: %.2f ms\n", 1e-6 * min_ns);
    EXPECT_LT(min_ns, 50e6); // of 20: a busy machine does not matter
}

} // namespace
} // namespace springdrive::study
