// Covers engine/lab/limits for delays that are no whole number of periods: a subset of
// stability_agreement_test.cpp, which tries a hundred loops.
#include "tests/support/delayed_limits.h"

#include <gtest/gtest.h>

namespace springdrive::limits {
namespace {

TEST(DelayedLoops, GainLimitsAreWhereTrialsFindThem) {
    RecordProperty("worst", std::to_string(testing::expect_gain_limits_agree(15, 35)));
}

} // namespace
} // namespace springdrive::limits
