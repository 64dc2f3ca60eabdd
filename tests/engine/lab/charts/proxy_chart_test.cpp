// Covers engine/lab/charts/proxy_chart.cpp.
#include "engine/lab/charts/proxy_chart.h"

#include "tests/support/devices.h"

#include <gtest/gtest.h>

namespace springdrive::charts {
namespace {

TEST(ProxyChart, OnAThinPlateThePenaltyAlwaysFailsAndTheProxyIsExact) {
    ChartSetting setting;
    setting.repeats = 1;
    double last_share = 0.0;
    const SpeedAccuracyChart chart = thin_plate_chart(setting, [&](double share) {
        EXPECT_GT(share, last_share);
        last_share = share;
    });
    EXPECT_EQ(last_share, 1.0);
    EXPECT_EQ(chart.name, "proxies_thin_plate");
    ASSERT_EQ(chart.points.size(), 13U); // six meshes twice, and the primitive
    for (const ChartPoint &point : chart.points) {
        const bool is_penalty = point.method.find("penalty") != std::string::npos;
        EXPECT_EQ(point.stable, !is_penalty) << point.method;
        if (!is_penalty) {
            EXPECT_LT(point.error, 1e-15) << point.method; // round-off of 50 mm
        }
        EXPECT_GT(point.cost.min_ns, 0.0);
        EXPECT_LE(point.cost.min_ns, point.cost.max_ns);
    }
}

} // namespace
} // namespace springdrive::charts
