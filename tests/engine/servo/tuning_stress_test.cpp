// Covers passing inputs to a running servo, and bumpless_transfer.h: ten thousand random changes
// per second from another thread cause neither torn inputs nor steps of e_W. See
// tests/support/tuning_stress.h.
#include "tests/support/tuning_stress.h"

#include <gtest/gtest.h>

namespace springdrive::servo {
namespace {

TEST(TuningStress, CausesNeitherTornInputsNorSteps) {
    testing::TuningStress stress(1000.0);
    const testing::StressFigures figures = stress.run(2.0);
    EXPECT_EQ(figures.faults, 0U);
    EXPECT_GT(figures.published, 1000U); // even on a busy machine
    EXPECT_GT(figures.samples, 100U);
    RecordProperty("figures", figures.text());
}

} // namespace
} // namespace springdrive::servo
