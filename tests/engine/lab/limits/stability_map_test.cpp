// Covers engine/lab/limits/stability_map.cpp.
#include "engine/lab/limits/stability_map.h"

#include "device/core/phantom/kinematics.h"
#include "tests/support/devices.h"
#include "tests/support/stability_cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace springdrive::limits {
namespace {

MapAxis axis(std::string_view name, double from, double to, int steps) {
    return {loops::stability_parameter_named(name), {from, to}, steps};
}

TrialOptions of_a_map() {
    TrialOptions options = TrialOptions::with(SimulationEffects::electronics());
    options.longest_s = 1.0;
    return options;
}

TEST(MapAxis, SpreadsValuesByTheParametersScale) {
    const std::vector<double> gains = axis("kp", 0.1, 10.0, 3).values();
    ASSERT_EQ(gains.size(), 3U);
    EXPECT_NEAR(gains[0], 0.1, 1e-12);
    EXPECT_NEAR(gains[1], 1.0, 1e-12);
    EXPECT_EQ(gains[2], 10.0);
    const std::vector<double> from_zero = axis("kp", 0.0, 10.0, 3).values();
    EXPECT_EQ(from_zero, (std::vector<double>{0.0, 5.0, 10.0})); // 0 has no logarithm
    // A narrow range is spaced linearly, which gives round numbers on the axis.
    EXPECT_EQ(axis("kp", 10.0, 30.0, 3).values(), (std::vector<double>{10.0, 20.0, 30.0}));
    EXPECT_EQ(axis("d", 1.0, 4.0, 7).values(),
              (std::vector<double>{1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0}));
    EXPECT_EQ(axis("eta", 0.0, 1.0, 5).values().size(), 5U);
}

TEST(StabilityMap, EveryCellMatchesSingleCalls) {
    const MapAxis x = axis("kp", 2.0, 200.0, 6);
    const MapAxis y = axis("dR", 0.1, 2.0, 4);
    const std::vector<MapCell> cells = stability_map(testing::firm(), x, y, [](double) {});
    ASSERT_EQ(cells.size(), 24U);
    int stable = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const MapCell &cell = cells[i];
        EXPECT_EQ(cell.x, x.values()[i % 6]);
        EXPECT_EQ(cell.y, y.values()[i / 6]);
        loops::StabilityCase there = testing::firm();
        there.tuning.K_P_V_per_rad = cell.x;
        there.net_resistance_Ohm = cell.y;
        EXPECT_EQ(cell.eigenvalue, loops::worst_member(there).eigenvalue);
        EXPECT_EQ(cell.stable, is_stable_simulated(there, of_a_map())) << cell.x << " " << cell.y;
        stable += cell.stable ? 1 : 0;
    }
    EXPECT_GT(stable, 4);
    EXPECT_LT(stable, 20);
}

TEST(StabilityMap, ReportsTheTipsRemainingSpeed) {
    loops::StabilityCase which = testing::firm();
    which.hands = {loops::no_hand()};
    which.rotor = device::RotorLoad{1e-5, 1e-5, 0.0};
    const std::vector<MapCell> cells =
        stability_map(which, axis("kp", 2.0, 300.0, 3), axis("d", 0.0, 1.0, 3), [](double) {});
    const double lever_m = device::motor_jacobian(which.device.geometry, which.q_rad).col(1).norm();
    for (const MapCell &cell : cells) {
        loops::StabilityCase there = which;
        there.tuning.K_P_V_per_rad = cell.x;
        there.delay_periods = cell.y;
        const Trial trial = simulated(there, loops::members(there).front(), of_a_map());
        EXPECT_DOUBLE_EQ(cell.remaining_m_per_s, trial.last_rate_rad_per_s * lever_m);
        EXPECT_EQ(cell.stable, trial.stable);
    }
    EXPECT_LT(cells.front().remaining_m_per_s, cells.back().remaining_m_per_s);
}

TEST(StabilityMap, OfTheWholeLinkage) {
    loops::StabilityCase which = testing::firm();
    which.freedom = loops::Freedom::three_motors;
    which.hands = {loops::no_hand(), loops::hand_of_firmness(0.5), loops::hand_of_firmness(1.0)};
    const std::vector<MapCell> cells =
        stability_map(which, axis("kp", 2.0, 300.0, 2), axis("d", 0.0, 1.0, 2), [](double) {});
    EXPECT_TRUE(cells.front().stable);
    EXPECT_LT(cells.front().eigenvalue, 1.0);
    EXPECT_FALSE(cells.back().stable);
    EXPECT_GT(cells.back().eigenvalue, 1.0);
    EXPECT_GT(cells.back().remaining_m_per_s, cells.front().remaining_m_per_s);
}

TEST(StabilityMap, ReportsItsProgress) {
    std::vector<double> told;
    const std::vector<MapCell> cells =
        stability_map(testing::firm(), axis("kp", 1.0, 3.0, 3), axis("kd", 0.001, 0.003, 3),
                      [&told](double share) { told.push_back(share); });
    ASSERT_EQ(told.size(), cells.size());
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
    EXPECT_EQ(told.back(), 1.0);
}

} // namespace
} // namespace springdrive::limits
