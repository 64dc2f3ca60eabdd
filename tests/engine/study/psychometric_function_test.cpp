// Covers engine/study/methods/{psychometric_function,scale}.cpp.
#include "engine/study/methods/psychometric_function.h"
#include "tests/engine/study/refusals.h"

#include <gtest/gtest.h>

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

} // namespace
} // namespace springdrive::study
