// Covers engine/study/methods/psychometric_function.cpp and engine/study/analysis/posterior.cpp:
// priors and functions; the posterior against closed forms and by brute force, Simpson's rule over
// the whole ranges without zooming in.
#include "engine/study/analysis/posterior.h"
#include "engine/study/methods/psychometric_function.h"
#include "tests/engine/study/refusals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace springdrive::study {
namespace {

constexpr std::array kShapes{Shape::cumulative_normal, Shape::logistic, Shape::weibull};
constexpr double kRounding = 1e-14; // some tens of last bits of values near 1

PsychometricFunction function_of(Shape shape, Scale scale) {
    return {{shape, scale}, 2.5, 1.75, 0.25, 0.03};
}

TEST(PsychometricFunction, HasTheTabulatedValuesOfItsShapes) {
    // Abramowitz & Stegun (1964), table 26.1.
    EXPECT_NEAR(core_proportion(Shape::cumulative_normal, 1.0), 0.841344746068543, 1e-15);
    EXPECT_NEAR(core_proportion(Shape::cumulative_normal, -1.96), 0.024997895148220, 1e-15);
    EXPECT_NEAR(core_argument(Shape::cumulative_normal, 0.975), 1.959963984540054, 1e-14);
    EXPECT_EQ(core_at_threshold(Shape::cumulative_normal), 0.5);
    EXPECT_EQ(core_at_threshold(Shape::logistic), 0.5);
    EXPECT_NEAR(core_at_threshold(Shape::weibull), 1.0 - std::exp(-1.0), kRounding);
}

TEST(PsychometricFunction, OnALogarithmicScaleIsWeibullsAndHillsFunctionOfTheLevel) {
    PsychometricFunction function = function_of(Shape::weibull, Scale::logarithmic);
    for (const double x : {0.1, 1.0, 2.5, 4.0, 20.0}) {
        const double ratio = std::pow(x / 2.5, 1.75);
        function.family.shape = Shape::weibull;
        EXPECT_NEAR(proportion_at(function, x), 0.25 + 0.72 * (1.0 - std::exp(-ratio)), kRounding);
        function.family.shape = Shape::logistic;
        EXPECT_NEAR(proportion_at(function, x), 0.25 + 0.72 / (1.0 + 1.0 / ratio), kRounding);
    }
    EXPECT_EQ(proportion_at(function, 0.0), 0.25); // without a stimulus
}

TEST(PsychometricFunction, OnALinearScaleIsFechnersFunctionOfTheLevel) {
    const PsychometricFunction function = function_of(Shape::cumulative_normal, Scale::linear);
    for (const double x : {-3.0, 0.0, 2.5, 4.0}) {
        const double z = (x - 2.5) * 1.75;
        EXPECT_NEAR(proportion_at(function, x),
                    0.25 + 0.72 * 0.5 * (1.0 + std::erf(z / std::sqrt(2.0))), kRounding);
    }
}

TEST(PsychometricFunction, LevelsAndProportionsAreInverse) {
    for (const Shape shape : kShapes) {
        for (const Scale scale : {Scale::linear, Scale::logarithmic}) {
            const PsychometricFunction function = function_of(shape, scale);
            for (const double proportion : {0.26, 0.5, 0.75, 0.96}) {
                const double level = level_at(function, proportion).value();
                EXPECT_NEAR(proportion_at(function, level), proportion, kRounding);
            }
            EXPECT_NEAR(level_at_core(function, core_at_threshold(shape)), 2.5, 1e-13);
            EXPECT_FALSE(level_at(function, 0.25).has_value());
            EXPECT_FALSE(level_at(function, 0.97).has_value());
        }
    }
}

TEST(PsychometricFunction, DensityIsTheDerivative) {
    constexpr double kStep = 1e-5; // central difference: error below 1e-10
    for (const Shape shape : kShapes) {
        for (const double z : {-3.0, -0.4, 0.0, 1.1, 2.0}) {
            const double slope =
                (core_proportion(shape, z + kStep) - core_proportion(shape, z - kStep)) /
                (2.0 * kStep);
            EXPECT_NEAR(core_density(shape, z), slope, 1e-10);
            EXPECT_GT(slope, 1e-3);
        }
        EXPECT_EQ(core_density(shape, 1e4), 0.0);
        EXPECT_EQ(core_density(shape, -1e4), 0.0);
    }
}

TEST(PsychometricFunction, SaysWhatIsWrongWithIt) {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const auto error = [](double threshold, double slope, double lapse = 0.02,
                          Scale scale = Scale::logarithmic) {
        return validate(
            PsychometricFunction{{Shape::weibull, scale}, threshold, slope, 0.5, lapse});
    };
    std::vector<testing::Refusal> all{
        {error(0.0, 3.5), "threshold is 0; it must be from 1e-06 to 1e+06"},
        {error(0.0, 3.5, 0.02, Scale::linear), ""},
        {error(1.0, -1.0), "slope is -1; it must be from 1e-06 to 1e+06"},
        {error(1.0, 3.5, 0.6), "lapse is 0.6; it must be from 0 to 0.5"},
        {error(1e6, 1e6), ""},
        {error(1e-6, 1e-6), ""},
    };
    for (const double wrong : {kNaN, kInfinity, 1.1e6, 0.9e-6, 1e-300}) {
        all.push_back({error(wrong, 3.5), "threshold is "});
        all.push_back({error(1.0, wrong), "slope is "});
    }
    testing::expect_refusals(all);
}

const Prior kUniform{Scale::logarithmic, 0.5, 8.0, Density::uniform, 0.0, 1.0};
const Prior kNormal{Scale::linear, -1.0, 4.0, Density::normal, 1.0, 2.0};

TEST(Prior, GridIsTheMidpointRule) {
    const PriorGrid grid = grid_of(kUniform, 4); // cells end at 0.5, 1, 2, 4, 8
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(grid.values[i], std::sqrt(0.5) * std::pow(2.0, static_cast<double>(i)), 1e-14);
        EXPECT_EQ(grid.weights[i], 0.25);
    }
    const PriorGrid normal = grid_of(kNormal, 50);
    EXPECT_NEAR(std::accumulate(normal.weights.begin(), normal.weights.end(), 0.0), 1.0, 1e-14);
    EXPECT_NEAR(normal.weights[30] / normal.weights[20],
                std::exp(-0.5 * (std::pow((normal.values[30] - 1.0) / 2.0, 2) -
                                 std::pow((normal.values[20] - 1.0) / 2.0, 2))),
                1e-13);
}

TEST(Prior, QuantilesCutTheGridsWeightAtTheirShare) {
    constexpr int kPoints = 100'000; // so a cell has a share of 1e-5 or so
    for (const Prior &prior : {kUniform, kNormal}) {
        const PriorGrid grid = grid_of(prior, kPoints);
        for (const double share : {0.0, 0.025, 0.5, 0.9, 1.0}) {
            const double cut = quantile(prior, share);
            double below = 0.0;
            for (std::size_t i = 0; i < grid.values.size(); ++i) {
                below += grid.values[i] < cut ? grid.weights[i] : 0.0;
            }
            EXPECT_NEAR(below, share, 3e-5);
        }
        EXPECT_NEAR(quantile(prior, 0.0), prior.minimum, 1e-12);
        EXPECT_NEAR(quantile(prior, 1.0), prior.maximum, 1e-12);
    }
}

TEST(Prior, OfAKnownValueHasOneNode) {
    const PriorGrid grid = grid_of(known(0.5), 7);
    EXPECT_EQ(grid.values, std::vector{0.5});
    EXPECT_EQ(grid.weights, std::vector{1.0});
    EXPECT_EQ(quantile(known(0.5), 0.3), 0.5);
    EXPECT_EQ(validate(known(0.5), "guess"), "");
}

TEST(Prior, SaysWhatIsWrongWithIt) {
    const auto error = [](const Prior &prior, const auto &change) {
        return validate(testing::spoilt(prior, change), "slope");
    };
    testing::expect_refusals({
        {validate(kUniform, "slope"), ""},
        {validate(kNormal, "slope"), ""},
        {error(kUniform, [](Prior &p) { p.minimum = 0.0; }),
         "slope.minimum is 0; it must be a finite number above 0"},
        {error(kUniform, [](Prior &p) { p.maximum = 0.25; }),
         "slope.maximum is 0.25; it must be from 0.5"},
        {error(kNormal, [](Prior &p) { p.mean = 5.0; }),
         "slope.mean is 5; it must be from -1 to 4"},
        {error(kNormal, [](Prior &p) { p.deviation = 0.0; }),
         "slope.deviation is 0; it must be a finite number above 0"},
    });
}

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
