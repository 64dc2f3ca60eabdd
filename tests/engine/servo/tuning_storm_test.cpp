// Covers passing inputs to a running servo, and bumpless_transfer.h: ten thousand random changes
// per second from another thread cause neither torn inputs nor steps of e_W. See
// tests/support/tuning_storm.h.
#include "tests/support/tuning_storm.h"

#include <gtest/gtest.h>

namespace springdrive::servo {
namespace {

TEST(TuningStorm, NeitherTearsNorJolts) {
    testing::TuningStorm storm(1000.0);
    const testing::StormFigures figures = storm.blow(2.0);
    EXPECT_EQ(figures.faults, 0U);
    EXPECT_GT(figures.published, 1000U); // even on a busy machine
    EXPECT_GT(figures.samples, 100U);
    RecordProperty("figures", figures.text());
}

} // namespace
} // namespace springdrive::servo
