// Covers engine/servo/safety_limits.cpp.
#include "engine/servo/safety_limits.h"

#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <string>

namespace springdrive::servo {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

void expect_equal(const SafetyLimits &a, const SafetyLimits &b) {
    for (const SafetyLimit &limit : kSafetyLimits) {
        EXPECT_EQ(a.*limit.value, b.*limit.value) << limit.name;
    }
}

TEST(SafetyLimits, AreThoseOfTheDeviceFile) {
    const SafetyLimits limits = limits_of(testing::phantom_1_0());
    EXPECT_EQ(limits.voltage_V, 12.0);
    EXPECT_EQ(limits.current_A, 5.5);
    EXPECT_EQ(limits.winding_C, 100.0);
    EXPECT_EQ(limits.tip_force_N, 8.5);
    EXPECT_EQ(limits.tip_speed_m_per_s, 2.0);
    EXPECT_NEAR(limits.beyond_stops_rad, 3.0 * 3.141592653589793 / 180.0, 1e-15);
    EXPECT_EQ(limits.generated_energy_J, 0.03);
    EXPECT_DOUBLE_EQ(limits.late_s, 0.05);
    EXPECT_DOUBLE_EQ(limits.stale_s, 0.005);
    EXPECT_EQ(limits.window_silence_s, 2.0);
}

TEST(SafetyLimits, TheLargestLimitCountsForUnequalMotors) {
    device::DeviceDescription device = testing::phantom_1_0();
    device.motor[1].supply_V = 24.0;
    device.motor[2].peak_current_A = 9.0;
    device.motor[0].thermal.max_winding_C = 155.0;
    const SafetyLimits limits = limits_of(device);
    EXPECT_EQ(limits.voltage_V, 24.0);
    EXPECT_EQ(limits.current_A, 9.0);
    EXPECT_EQ(limits.winding_C, 155.0);
}

TEST(SafetyLimits, TheListNamesEveryFieldOnce) {
    // Every double of the struct, each once.
    EXPECT_EQ(sizeof(SafetyLimits), kSafetyLimits.size() * sizeof(double));
    SafetyLimits counted;
    double number = 0.0;
    for (const SafetyLimit &limit : kSafetyLimits) {
        counted.*limit.value = ++number;
    }
    std::set<std::string> names;
    number = 0.0;
    for (const SafetyLimit &limit : kSafetyLimits) {
        EXPECT_EQ(counted.*limit.value, ++number) << limit.name;
        EXPECT_TRUE(names.insert(limit.name).second);
        EXPECT_GT(limit.shown_per_si, 0.0);
    }
}

TEST(SafetyLimits, LoweringOneLimitChangesNoOther) {
    const SafetyLimits device = limits_of(testing::phantom_1_0());
    for (const SafetyLimit &changed : kSafetyLimits) {
        for (const double share : {1e-3, 0.5, 0.999}) {
            SafetyLimits request = unlowered();
            request.*changed.value = share * (device.*changed.value);
            SafetyLimits expected = device;
            expected.*changed.value = share * (device.*changed.value);
            expect_equal(lowered(device, request), expected);
        }
    }
}

TEST(SafetyLimits, NoneCanBeRaised) {
    const SafetyLimits device = limits_of(testing::phantom_1_0());
    for (const SafetyLimit &changed : kSafetyLimits) {
        for (const double share : {1.0, 1.001, 1e6}) {
            SafetyLimits request = unlowered();
            request.*changed.value = share * (device.*changed.value);
            expect_equal(lowered(device, request), device);
        }
    }
}

TEST(SafetyLimits, InvalidRequestsChangeNothing) {
    const SafetyLimits device = limits_of(testing::phantom_1_0());
    expect_equal(lowered(device, unlowered()), device);
    for (const SafetyLimit &changed : kSafetyLimits) {
        for (const double requested : {kNaN, -kNaN, 0.0, -0.0, -1.0, -kInfinity, kInfinity}) {
            SafetyLimits request = unlowered();
            request.*changed.value = requested;
            expect_equal(lowered(device, request), device);
        }
    }
}

} // namespace
} // namespace springdrive::servo
