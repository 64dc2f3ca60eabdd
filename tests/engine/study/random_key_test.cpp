// Covers engine/study/methods/random_key.cpp and base/split_mix.h.
#include "base/split_mix.h"
#include "engine/study/methods/random_key.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

namespace springdrive::study {
namespace {

/// Σ (observed − expected)²/expected for equally likely cells.
double chi_squared(const std::vector<int> &counts) {
    double total = 0.0;
    for (const int count : counts) {
        total += count;
    }
    const double expected = total / static_cast<double>(counts.size());
    double sum = 0.0;
    for (const int count : counts) {
        sum += (count - expected) * (count - expected) / expected;
    }
    return sum;
}

TEST(SplitMix, GivesThePublishedSequence) {
    // The first values for seed 1234567 (rosettacode.org, Pseudo-random numbers/Splitmix64).
    constexpr std::uint64_t kSeed = 1234567;
    EXPECT_EQ(split_mix::value(kSeed, 0), 6457827717110365317U);
    EXPECT_EQ(split_mix::value(kSeed, 1), 3203168211198807973U);
    EXPECT_EQ(split_mix::value(kSeed, 2), 9817491932198370423U);
}

TEST(RandomKey, ChildrenAreUniformAndIndependentOfTheirNeighbours) {
    // 16 × 16 cells of a child's value and that of the next child, of the next key's same child,
    // and of its own child: χ² with 255 degrees of freedom has mean 255 and deviation 22.6.
    constexpr int kPairs = 100'000;
    std::array<std::vector<int>, 3> counts;
    counts.fill(std::vector<int>(256, 0));
    const auto cell = [](double value) { return static_cast<std::size_t>(value * 16.0); };
    for (int i = 0; i < kPairs; ++i) {
        const auto number = static_cast<std::uint64_t>(i);
        const RandomKey one = child(key_of(1, 1), number);
        const std::size_t row = 16 * cell(uniform(one));
        ++counts[0][row + cell(uniform(child(key_of(1, 1), number + 1)))];
        ++counts[1][row + cell(uniform(child(key_of(1, 2), number)))];
        ++counts[2][row + cell(uniform(child(one, 0)))];
    }
    for (const std::vector<int> &table : counts) {
        EXPECT_NEAR(chi_squared(table), 255.0, 4.0 * 22.6);
    }
}

TEST(RandomKey, ShufflesIntoAllOrdersAlike) {
    std::map<std::vector<int>, int> seen;
    for (std::uint64_t i = 0; i < 24'000; ++i) {
        std::vector<int> order{0, 1, 2, 3};
        shuffle(child(key_of(7, 3), i), std::span(order));
        ++seen[order];
    }
    std::vector<int> counts;
    for (const auto &[order, count] : seen) {
        counts.push_back(count);
    }
    ASSERT_EQ(counts.size(), 24U);
    EXPECT_NEAR(chi_squared(counts), 23.0, 4.0 * std::sqrt(46.0)); // 23 degrees of freedom
}

TEST(RandomKey, DependsOnSeedAndParticipant) {
    EXPECT_EQ(key_of(1, 2), key_of(1, 2));
    EXPECT_NE(key_of(1, 2), key_of(2, 1));
    EXPECT_NE(key_of(1, 2), key_of(1, 3));
    EXPECT_NE(child({5}, 0), RandomKey{5});
}

} // namespace
} // namespace springdrive::study
