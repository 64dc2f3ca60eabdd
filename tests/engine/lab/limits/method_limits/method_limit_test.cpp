// Covers engine/lab/limits/method_limits/method_limit.cpp.
#include "engine/lab/limits/method_limits/method_limit.h"

#include <gtest/gtest.h>

#include <cmath>

namespace springdrive::limits {
namespace {

LimitTrial trial(double holds_at, double fails_at, const std::function<bool(double)> &holds) {
    return {{"method", "above", "m", "setting", {}, {}, {}}, holds_at, fails_at, false, holds};
}

TEST(MeasuredLine, IsEmptyWhereEverythingHolds) {
    EXPECT_EQ(measured(trial(1.0, 1e3, [](double) { return true; })).measured, std::nullopt);
}

TEST(MeasuredLine, IsFoundEvenWhereTheEndHoldsAgain) {
    const auto hole = [](double x) { return x < 10.0 || x > 100.0; };
    EXPECT_NEAR(measured(trial(1.0, 1e3, hole)).measured.value_or(0.0), 10.0, 2e-5);
    const auto between_signs = [](double x) { return std::abs(x) > 1.0; };
    EXPECT_NEAR(measured(trial(-6.0, 6.0, between_signs)).measured.value_or(0.0), -1.0, 2e-6);
}

TEST(MeasuredLine, OfWholeNumbersIsTheLastThatHolds) {
    for (int last = 0; last < 9; ++last) {
        LimitTrial line = trial(0.0, 9.0, [=](double x) {
            EXPECT_EQ(x, std::round(x));
            return x <= last;
        });
        line.whole = true;
        EXPECT_EQ(measured(line).measured, static_cast<double>(last));
    }
}

TEST(MeasuredLine, OfAValueIsItsReading) {
    LimitTrial line;
    line.line.predicted = 2.0;
    line.reading = [] { return std::optional(3.0); };
    EXPECT_EQ(measured(line).measured, 3.0);
    EXPECT_EQ(measured(line).predicted, 2.0);
}

} // namespace
} // namespace springdrive::limits
