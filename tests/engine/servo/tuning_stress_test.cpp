// Covers passing inputs to a running servo, and bumpless_transfer.h: ten thousand random changes
// per second from another thread cause neither torn inputs nor steps of e_W. See
// tests/support/tuning_stress.h.
#include "tests/support/cases.h"
#include "tests/support/tuning_stress.h"

#include <gtest/gtest.h>

namespace springdrive::servo {
namespace {

TEST(LongTuningStress, CausesNeitherTornInputsNorSteps) {
    const auto seconds = static_cast<unsigned>(testing::cases(4, 600));
    testing::TuningStress stress(1000.0);
    const testing::StressFigures figures = stress.run(seconds);
    EXPECT_EQ(figures.faults, 0U);
    EXPECT_GT(figures.published, 1000 * seconds);
    EXPECT_GT(figures.samples, 80 * seconds);
    EXPECT_GT(figures.felt, 8 * seconds);
    EXPECT_GT(figures.scenes, seconds / 2);
    RecordProperty("figures", figures.text());
}

} // namespace
} // namespace springdrive::servo
