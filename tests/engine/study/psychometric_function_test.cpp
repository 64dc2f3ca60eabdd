// Covers engine/study/methods/psychometric_function.cpp and scale.h.
#include "engine/study/methods/psychometric_function.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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
    EXPECT_EQ(validate(PsychometricFunction{}), "");
    PsychometricFunction bad;
    bad.threshold = 0.0;
    EXPECT_EQ(validate(bad), "threshold is 0; it must be from 1e-06 to 1e+06");
    bad.family.scale = Scale::linear;
    EXPECT_EQ(validate(bad), "");
    bad.threshold = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NE(validate(bad).find("threshold"), std::string::npos);
    bad = {};
    bad.slope = -1.0;
    EXPECT_EQ(validate(bad), "slope is -1; it must be from 1e-06 to 1e+06");
    for (const double wrong : {std::numeric_limits<double>::infinity(), 1.1e6, 0.9e-6, 1e-300}) {
        bad = {};
        bad.threshold = wrong;
        EXPECT_EQ(validate(bad).find("threshold is "), 0U) << wrong;
        bad = {};
        bad.slope = wrong;
        EXPECT_EQ(validate(bad).find("slope is "), 0U) << wrong;
    }
    for (const double right : {1e6, 1e-6}) {
        bad = {};
        bad.threshold = bad.slope = right;
        EXPECT_EQ(validate(bad), "") << right;
    }
    bad = {};
    bad.lapse = 0.6;
    EXPECT_EQ(validate(bad), "lapse is 0.6; it must be from 0 to 0.5");
}

} // namespace
} // namespace springdrive::study
