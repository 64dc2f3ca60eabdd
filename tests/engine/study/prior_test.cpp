// Covers engine/study/methods/prior.cpp.
#include "engine/study/methods/prior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace springdrive::study {
namespace {

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
    EXPECT_EQ(validate(kUniform, "threshold"), "");
    EXPECT_EQ(validate(kNormal, "threshold"), "");
    Prior bad = kUniform;
    bad.minimum = 0.0;
    EXPECT_EQ(validate(bad, "slope"), "slope.minimum is 0; it must be a finite number above 0");
    bad = kUniform;
    bad.maximum = 0.25;
    EXPECT_EQ(validate(bad, "slope").find("slope.maximum is 0.25; it must be from 0.5"), 0U);
    bad = kNormal;
    bad.mean = 5.0;
    EXPECT_EQ(validate(bad, "threshold"), "threshold.mean is 5; it must be from -1 to 4");
    bad = kNormal;
    bad.deviation = 0.0;
    EXPECT_EQ(validate(bad, "threshold"),
              "threshold.deviation is 0; it must be a finite number above 0");
}

} // namespace
} // namespace springdrive::study
