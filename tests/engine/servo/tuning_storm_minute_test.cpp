// The storm of tuning_storm_test.cpp for a minute.
#include "tests/support/tuning_storm.h"

#include <gtest/gtest.h>

namespace springdrive::servo {
namespace {

TEST(SlowTuningStorm, NeitherTearsNorJoltsForAMinute) {
    testing::TuningStorm storm(1000.0);
    const testing::StormFigures figures = storm.blow(60.0);
    EXPECT_EQ(figures.faults, 0U);
    EXPECT_GT(figures.published, 100'000U);
    EXPECT_GT(figures.samples, 5'000U);
    EXPECT_GT(figures.felt, 500U);
    EXPECT_GT(figures.scenes, 50U);
    RecordProperty("figures", figures.text());
}

} // namespace
} // namespace springdrive::servo
