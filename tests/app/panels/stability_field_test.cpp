// Covers app/panels/stability_field.cpp, except its drawing.
#include "app/panels/stability_field.h"
#include "tests/support/devices.h"
#include "tests/support/stability_cases.h"

#include <gtest/gtest.h>

namespace springdrive::app {
namespace {

TEST(StabilityGrid, SpreadsByRatioBetweenItsEnds) {
    EXPECT_GT(StabilityGrid::K_P_V_per_rad(0), StabilityGrid::kMin_K_P_V_per_rad);
    EXPECT_LT(StabilityGrid::K_P_V_per_rad(StabilityGrid::kColumns - 1),
              StabilityGrid::kMax_K_P_V_per_rad);
    const double ratio = StabilityGrid::dR_Ohm(1) / StabilityGrid::dR_Ohm(0);
    EXPECT_NEAR(StabilityGrid::dR_Ohm(9) / StabilityGrid::dR_Ohm(8), ratio, 1e-12);
    // Half a cell lies beyond the centres of the outermost.
    EXPECT_NEAR(StabilityGrid::dR_Ohm(0) * StabilityGrid::dR_Ohm(StabilityGrid::kRows - 1),
                StabilityGrid::kMin_dR_Ohm * StabilityGrid::kMax_dR_Ohm, 1e-12);
}

TEST(StabilityGrid, EveryCellIsWhatASingleTuningGives) {
    BackgroundTalk talk;
    const StabilityGrid grid = stability_grid(testing::firm(), talk);
    ASSERT_EQ(grid.eigenvalue.size(),
              static_cast<std::size_t>(StabilityGrid::kColumns * StabilityGrid::kRows));
    EXPECT_EQ(talk.share, 1.0);
    int stable = 0;
    for (int row = 0; row < StabilityGrid::kRows; row += 3) {
        for (int column = 0; column < StabilityGrid::kColumns; column += 5) {
            // Set in the tuning, whereas the grid sets the net resistance.
            loops::StabilityCase there = testing::firm();
            there.tuning.K_P_V_per_rad = StabilityGrid::K_P_V_per_rad(column);
            there.tuning.dR_Ohm = StabilityGrid::dR_Ohm(row);
            // The motors of this device are equal, so both are the same except for rounding.
            EXPECT_NEAR(grid.at(column, row), loops::worst_member(there).eigenvalue, 1e-9);
            stable += grid.at(column, row) < 1.0 ? 1 : 0;
        }
    }
    EXPECT_GT(stable, 5); // both sides of the limit occur
    EXPECT_LT(stable, 43);
}

TEST(StabilityGrid, EndsEarlyWhereNobodyWantsIt) {
    BackgroundTalk talk;
    talk.is_cancelled = true;
    const StabilityGrid grid = stability_grid(testing::firm(), talk);
    EXPECT_EQ(grid.at(3, 3), 0.0); // not computed
}

} // namespace
} // namespace springdrive::app
