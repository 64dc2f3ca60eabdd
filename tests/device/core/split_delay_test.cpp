// Covers device/core/split_delay.h.
#include "device/core/split_delay.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace springdrive::device {
namespace {

TEST(SplitDelay, AddsUpExactly) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> delays(0.0, 16.0);
    for (int i = 0; i < 1000; ++i) {
        const double d = delays(random);
        const SplitDelay split = split_delay(d);
        EXPECT_EQ(split.whole + split.fraction, d);
        EXPECT_GE(split.fraction, 0.0);
        EXPECT_LT(split.fraction, 1.0);
        EXPECT_EQ(split.held(), std::ceil(d));
    }
}

TEST(SplitDelay, BothSidesOfWholeNumbers) {
    for (const int whole : {0, 1, 2, 8}) {
        EXPECT_EQ(split_delay(whole).whole, whole);
        EXPECT_EQ(split_delay(whole).fraction, 0.0);
        EXPECT_EQ(split_delay(whole).held(), whole);
        const double above = std::nextafter(static_cast<double>(whole), 99.0);
        EXPECT_EQ(split_delay(above).whole, whole);
        EXPECT_GT(split_delay(above).fraction, 0.0);
        EXPECT_EQ(split_delay(above).held(), whole + 1);
    }
    EXPECT_EQ(split_delay(std::nextafter(2.0, 0.0)).whole, 1);
    EXPECT_EQ(split_delay(std::nextafter(2.0, 0.0)).held(), 2);
}

} // namespace
} // namespace springdrive::device
