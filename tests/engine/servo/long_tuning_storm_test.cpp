// The stress test of tuning_storm_test.cpp, for longer.
#include "tests/support/cases.h"
#include "tests/support/tuning_storm.h"

#include <gtest/gtest.h>

namespace springdrive::servo {
namespace {

TEST(LongTuningStorm, NeitherTearsNorJolts) {
    const auto seconds = static_cast<unsigned>(testing::cases(4, 600));
    testing::TuningStorm storm(1000.0);
    const testing::StormFigures figures = storm.blow(seconds);
    EXPECT_EQ(figures.faults, 0U);
    EXPECT_GT(figures.published, 1000 * seconds);
    EXPECT_GT(figures.samples, 80 * seconds);
    EXPECT_GT(figures.felt, 8 * seconds);
    EXPECT_GT(figures.scenes, seconds / 2);
    RecordProperty("figures", figures.text());
}

} // namespace
} // namespace springdrive::servo
