// Covers engine/lab/charts/servo_rate_chart.cpp.
#include "engine/lab/charts/servo_rate_chart.h"

#include "tests/support/devices.h"

#include <gtest/gtest.h>

namespace springdrive::charts {
namespace {

TEST(ServoRateChart, AFasterServoCostsMoreAndHasSmallerErrors) {
    ChartSetting setting;
    setting.device = testing::phantom_1_0();
    setting.repeats = 1;
    for (const auto make : {servo_rate_stiffness_chart, servo_rate_direction_chart}) {
        const rig::SpeedAccuracyChart chart = make(setting, [](double) {});
        ASSERT_EQ(chart.points.size(), 21U) << chart.name;
        EXPECT_EQ(chart.points.front().setting, "250 Hz");
        EXPECT_EQ(chart.points.back().setting, "20 kHz");
        for (std::size_t i = 1; i < chart.points.size(); ++i) {
            const rig::ChartPoint &before = chart.points[i - 1];
            const rig::ChartPoint &point = chart.points[i];
            if (point.method == before.method) {
                EXPECT_GT(point.cost.median_ns, before.cost.median_ns);
                EXPECT_LT(point.error, before.error) << point.method << ' ' << point.setting;
                EXPECT_GE(point.stable, before.stable) << point.method << ' ' << point.setting;
            }
        }
    }
}

} // namespace
} // namespace springdrive::charts
