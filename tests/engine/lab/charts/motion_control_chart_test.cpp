// Covers engine/lab/charts/motion_control_chart.cpp.
#include "engine/lab/charts/motion_control_chart.h"

#include "base/input_error.h"
#include "tests/engine/lab/charts/quick_setting.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <map>
#include <vector>

namespace springdrive::charts {
namespace {

std::map<std::string, std::vector<ChartPoint>> lines_of(const SpeedAccuracyChart &chart) {
    std::map<std::string, std::vector<ChartPoint>> lines;
    for (const ChartPoint &point : chart.points) {
        lines[point.method].push_back(point);
    }
    return lines;
}

TEST(MotionControlChart, FinerEncodersReduceTheErrorOfTheTransposeAndNotOfTheInverse) {
    auto lines = lines_of(motion_direction_chart(testing::quick_setting(), [](double) {}));
    ASSERT_EQ(lines.size(), 4U);
    for (const auto &[method, points] : lines) {
        ASSERT_EQ(points.size(), 5U);
        const bool is_inverse = method.starts_with("inverse");
        for (std::size_t i = 1; i < points.size(); ++i) { // each four times as fine
            const double ratio = points[i - 1].error / points[i].error;
            EXPECT_NEAR(ratio, is_inverse ? 1.0 : 4.0, is_inverse ? 0.05 : 1.5) << method;
        }
        if (is_inverse) {
            EXPECT_GT(points.back().error, 25.0); // the perceptible angle of the paper
        } else {
            EXPECT_LT(points.front().error, 0.2);
        }
    }
}

TEST(MotionControlChart, GlobalAlphaIsSofterThanOnTheFlyAndThatThanTheInverse) {
    auto lines = lines_of(motion_stiffness_chart(testing::quick_setting(), [](double) {}));
    ASSERT_EQ(lines.size(), 4U);
    const double inverse = lines["inverse (18)"].front().error;
    const double on_the_fly = lines["transpose (23), α on the fly"].front().error;
    const double global = lines["transpose, global α"].front().error;
    EXPECT_LT(inverse, on_the_fly); // (28)
    EXPECT_LT(on_the_fly, global);  // the global α is the minimum
    const std::vector<ChartPoint> &by_hand = lines["transpose, α by hand"];
    for (std::size_t i = 1; i < by_hand.size(); ++i) { // (27): twice the α, half the compliance
        EXPECT_NEAR(by_hand[i - 1].error / by_hand[i].error, 2.0, 1e-6);
        EXPECT_LE(by_hand[i].stable, by_hand[i - 1].stable);
    }
    EXPECT_TRUE(by_hand.front().stable);
    EXPECT_FALSE(by_hand.back().stable);
}

TEST(MotionControlChart, RefusesATuningWithoutStaticStiffness) {
    ChartSetting without = testing::quick_setting();
    without.tuning.K_P_V_per_rad = 0.0;
    EXPECT_THROW((void)motion_direction_chart(without, [](double) {}), InputError);
    without = testing::quick_setting();
    without.tuning.eta = 1.0;
    EXPECT_THROW((void)motion_stiffness_chart(without, [](double) {}), InputError);
}

} // namespace
} // namespace springdrive::charts
