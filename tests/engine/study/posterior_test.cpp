// Covers engine/study/analysis/posterior.cpp, against closed forms and a brute-force posterior:
// Simpson's rule over the whole ranges, without zooming in.
#include "engine/study/analysis/posterior.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace springdrive::study {
namespace {

const std::vector<LevelCount> kSixLevels{{0.25, 19, 40}, {0.5, 23, 40}, {1.0, 31, 40},
                                         {2.0, 37, 40},  {4.0, 37, 40}, {8.0, 38, 40}};

FunctionPriors weibull_priors() {
    FunctionPriors priors;
    priors.threshold = {Scale::logarithmic, 0.1, 10.0, Density::normal, 1.5, 1.0};
    priors.slope = {Scale::logarithmic, 0.5, 15.0};
    priors.guess = known(0.5);
    priors.lapse = {Scale::linear, 0.0, 0.1};
    return priors;
}

/// A marginal density at the nodes of Simpson's rule, of ln threshold, ln slope or lapse.
struct Marginal {
    Marginal(double first, double last, int steps) : weights(static_cast<std::size_t>(steps) + 1) {
        for (int i = 0; i <= steps; ++i) {
            nodes.push_back(first + (last - first) * i / steps);
        }
    }
    std::vector<double> nodes;
    std::vector<double> weights;
};

struct BruteForce {
    Marginal u{std::log(0.1), std::log(10.0), 300};
    Marginal v{std::log(0.5), std::log(15.0), 120};
    Marginal l{0.0, 0.1, 20};
};

double simpson_weight(std::size_t i, const Marginal &of) {
    return i == 0 || i + 1 == of.nodes.size() ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
}

BruteForce brute_force(const std::vector<LevelCount> &counts) {
    BruteForce brute;
    double sum = 0.0;
    for (std::size_t i = 0; i < brute.u.nodes.size(); ++i) {
        const double z = brute.u.nodes[i] - std::log(1.5);
        for (std::size_t j = 0; j < brute.v.nodes.size(); ++j) {
            std::vector<double> cores;
            for (const LevelCount &count : counts) {
                cores.push_back(1.0 - std::exp(-std::pow(count.level / std::exp(brute.u.nodes[i]),
                                                         std::exp(brute.v.nodes[j]))));
            }
            for (std::size_t k = 0; k < brute.l.nodes.size(); ++k) {
                double log_weight = -0.5 * z * z;
                for (std::size_t m = 0; m < counts.size(); ++m) {
                    const double psi = 0.5 + (0.5 - brute.l.nodes[k]) * cores[m];
                    const int wrong = counts[m].trials - counts[m].positive;
                    log_weight += counts[m].positive * std::log(psi) +
                                  (wrong > 0 ? wrong * std::log(1.0 - psi) : 0.0);
                }
                const double weight = std::exp(log_weight + 100.0) * simpson_weight(i, brute.u) *
                                      simpson_weight(j, brute.v) * simpson_weight(k, brute.l);
                sum += weight;
                brute.u.weights[i] += weight;
                brute.v.weights[j] += weight;
                brute.l.weights[k] += weight;
            }
        }
    }
    for (Marginal *marginal : {&brute.u, &brute.v, &brute.l}) {
        for (double &weight : marginal->weights) {
            weight /= sum;
        }
    }
    return brute;
}

struct Moments {
    double mean = 0.0;
    double deviation = 0.0;
};

Moments moments(const Marginal &of) {
    Moments result;
    for (std::size_t i = 0; i < of.nodes.size(); ++i) {
        result.mean += of.weights[i] * of.nodes[i];
    }
    for (std::size_t i = 0; i < of.nodes.size(); ++i) {
        result.deviation += of.weights[i] * std::pow(of.nodes[i] - result.mean, 2);
    }
    result.deviation = std::sqrt(result.deviation);
    return result;
}

/// The share below the middle between two nodes, from weights of Simpson's rule made those of the
/// midpoint rule.
double share_below_node(const Marginal &of, std::size_t node) {
    double below = 0.0;
    double sum = 0.0;
    for (std::size_t i = 0; i < of.nodes.size(); ++i) {
        const double weight = simpson_weight(i, of);
        const double density = of.weights[i] / weight * (weight == 1.0 ? 0.5 : 1.0);
        sum += density;
        below += i < node ? density : i == node ? 0.5 * density : 0.0;
    }
    return below / sum;
}

TEST(Posterior, IsThatOfBruteForce) {
    for (const int share : {1, 4}) { // all trials, and a quarter of them
        std::vector<LevelCount> counts = kSixLevels;
        for (LevelCount &count : counts) {
            count.positive /= share;
            count.trials /= share;
        }
        const Posterior posterior(counts, weibull_priors());
        const BruteForce brute = brute_force(counts);
        // A thousandth of the posterior's deviation changes the coverage of an interval by less
        // than 0.02 %.
        const auto expect_moments = [&](FunctionParameter parameter, const Marginal &of) {
            const Moments expected = moments(of);
            const PosteriorSummary found = posterior.of(parameter);
            const bool is_lapse = parameter == FunctionParameter::lapse;
            EXPECT_NEAR(is_lapse ? found.mean : std::log(found.mean), expected.mean,
                        1e-3 * expected.deviation);
            EXPECT_NEAR(found.deviation_on_scale, expected.deviation, 1e-3 * expected.deviation);
        };
        expect_moments(FunctionParameter::threshold, brute.u);
        expect_moments(FunctionParameter::slope, brute.v);
        expect_moments(FunctionParameter::lapse, brute.l);
        for (const std::size_t node : {140U, 150U, 160U, 175U}) {
            EXPECT_NEAR(
                posterior.share_below(FunctionParameter::threshold, std::exp(brute.u.nodes[node])),
                share_below_node(brute.u, node), 1e-3);
        }
        EXPECT_GT(share_below_node(brute.u, 175), 0.5);
        EXPECT_LT(share_below_node(brute.u, 140), 0.5);
    }
}

/// P(X <= x) of Beta(k + 1, n − k + 1): at least k + 1 of n + 1 uniform values are below x.
double beta_proportion(int k, int n, double x) {
    double sum = 0.0;
    for (int i = k + 1; i <= n + 1; ++i) {
        sum += std::exp(std::lgamma(n + 2.0) - std::lgamma(i + 1.0) - std::lgamma(n + 2.0 - i) +
                        i * std::log(x) + (n + 1 - i) * std::log1p(-x));
    }
    return sum;
}

TEST(Posterior, OfARateIsABetaDistribution) {
    // Far below a known threshold answers are guesses, far above it lapses: with a uniform prior
    // from 0 to 1 their rates have beta distributions (Bayes 1763).
    FunctionPriors priors;
    priors.family = {Shape::logistic, Scale::linear};
    priors.threshold = known(0.0);
    priors.slope = known(1.0);
    priors.guess = {Scale::linear, 0.0, 1.0};
    priors.lapse = known(0.0);
    const PosteriorSummary guess =
        Posterior(std::vector<LevelCount>{{-1000.0, 7, 50}}, priors).of(FunctionParameter::guess);
    EXPECT_NEAR(guess.mean, 8.0 / 52.0, 1e-4);
    EXPECT_NEAR(beta_proportion(7, 50, guess.low), 0.025, 1e-3);
    EXPECT_NEAR(beta_proportion(7, 50, guess.high), 0.975, 1e-3);

    priors.guess = known(0.0);
    priors.lapse = {Scale::linear, 0.0, 1.0};
    const PosteriorSummary lapse =
        Posterior(std::vector<LevelCount>{{1000.0, 43, 50}}, priors).of(FunctionParameter::lapse);
    EXPECT_NEAR(lapse.mean, 8.0 / 52.0, 1e-4);
    EXPECT_NEAR(beta_proportion(7, 50, lapse.low), 0.025, 1e-3);
    EXPECT_NEAR(beta_proportion(7, 50, lapse.high), 0.975, 1e-3);
}

TEST(Posterior, FindsAPeakThatIsNarrowInItsPrior) {
    FunctionPriors priors;
    priors.family = {Shape::cumulative_normal, Scale::linear};
    priors.threshold = {Scale::linear, -1000.0, 1000.0};
    priors.slope = known(1.0);
    priors.guess = known(0.0);
    priors.lapse = known(0.0);
    // With n/2 of n at one level: Φ(x − α) has information n φ²(0)/(1/4) = 2n/π, so the deviation
    // is √(π/2n), to within 1/n.
    const PosteriorSummary threshold =
        Posterior(std::vector<LevelCount>{{37.3, 5000, 10'000}}, priors)
            .of(FunctionParameter::threshold);
    const double deviation = std::sqrt(std::acos(-1.0) / 20'000.0);
    EXPECT_NEAR(threshold.mean, 37.3, 1e-3 * deviation);
    EXPECT_NEAR(threshold.deviation_on_scale, deviation, 2e-3 * deviation);
    EXPECT_NEAR(threshold.high, 37.3 + 1.95996 * deviation, 5e-3 * deviation);
}

TEST(Posterior, WithoutTrialsIsThePrior) {
    FunctionPriors priors = weibull_priors();
    const Posterior posterior(std::vector<LevelCount>{}, priors);
    for (const double share : {0.025, 0.5, 0.975}) {
        EXPECT_NEAR(
            posterior.share_below(FunctionParameter::threshold, quantile(priors.threshold, share)),
            share, 1e-3);
        EXPECT_NEAR(posterior.share_below(FunctionParameter::slope, quantile(priors.slope, share)),
                    share, 1e-12);
    }
}

TEST(Posterior, LevelsOfOtherProportionsFollowFromThresholdAndSlope) {
    const Posterior posterior(kSixLevels, weibull_priors());
    const PosteriorSummary threshold = posterior.of(FunctionParameter::threshold);
    const PosteriorSummary same = posterior.of_level_at(core_at_threshold(Shape::weibull));
    // z is 0 there to rounding, so that all slopes of a threshold coincide.
    EXPECT_NEAR(std::log(same.mean / threshold.mean), 0.0, 1e-12);
    EXPECT_NEAR(same.deviation_on_scale, threshold.deviation_on_scale, 1e-12);
    // There, the density within a cell of a sixth of a deviation is taken as even: to within
    // a thousandth of the share.
    const double little = 0.02 * threshold.deviation_on_scale;
    EXPECT_NEAR(std::log(same.low / threshold.low), 0.0, little);
    EXPECT_NEAR(std::log(same.high / threshold.high), 0.0, little);
    // Of a known slope, all levels are shifted alike: by ln(−ln(1 − F))/β.
    FunctionPriors priors = weibull_priors();
    priors.slope = known(2.0);
    const Posterior known_slope(kSixLevels, priors);
    const double shift = std::log(std::log(10.0)) / 2.0;
    EXPECT_NEAR(std::log(known_slope.of_level_at(0.9).mean /
                         known_slope.of(FunctionParameter::threshold).mean),
                shift, 1e-12);
    EXPECT_LT(posterior.of_level_at(0.5).high, posterior.of_level_at(0.9).high);
}

} // namespace
} // namespace springdrive::study
