// Covers base/hand_over.h, each queue with its two threads.
#include "base/hand_over.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <stdexcept>
#include <thread>

namespace springdrive {
namespace {

/// Torn if its parts differ.
struct Wide {
    std::array<std::uint64_t, 32> parts{};

    static Wide of(std::uint64_t value) {
        Wide wide;
        wide.parts.fill(value);
        return wide;
    }
    [[nodiscard]] bool is_whole() const {
        for (const std::uint64_t part : parts) {
            if (part != parts.front()) {
                return false;
            }
        }
        return true;
    }
};

TEST(LatestValue, KeepsTheInitialValueUntilThereIsANewerOne) {
    LatestValue<int> mailbox(7);
    EXPECT_EQ(mailbox.latest(), 7);
    mailbox.publish(8);
    mailbox.publish(9);
    EXPECT_EQ(mailbox.latest(), 9);
    EXPECT_EQ(mailbox.latest(), 9);
}

TEST(LatestValue, ArrivesWholeAndNeverGoesBack) {
    constexpr std::uint64_t kValues = 200'000;
    LatestValue<Wide> mailbox;
    std::thread writer([&mailbox] {
        for (std::uint64_t i = 1; i <= kValues; ++i) {
            mailbox.publish(Wide::of(i));
        }
    });
    std::uint64_t last = 0;
    while (last < kValues) {
        const Wide &value = mailbox.latest();
        ASSERT_TRUE(value.is_whole());
        ASSERT_GE(value.parts.front(), last);
        last = value.parts.front();
    }
    writer.join();
}

TEST(SampleRing, PassesEverySampleInOrder) {
    constexpr std::uint64_t kSamples = 200'000;
    SampleRing<Wide> ring(64);
    std::thread writer([&ring] {
        for (std::uint64_t i = 1; i <= kSamples;) {
            i += ring.push(Wide::of(i)) ? 1U : 0U;
        }
    });
    std::uint64_t last = 0;
    while (last < kSamples) {
        ring.drain([&last](const Wide &sample) {
            EXPECT_TRUE(sample.is_whole());
            EXPECT_EQ(sample.parts.front(), last + 1);
            last = sample.parts.front();
        });
    }
    writer.join();
}

TEST(SampleRing, DropsTheNewestWhenFullAndCountsIt) {
    SampleRing<int> ring(4);
    for (int i = 0; i < 4; ++i) {
        EXPECT_TRUE(ring.push(i));
    }
    EXPECT_FALSE(ring.push(4));
    EXPECT_EQ(ring.lost(), 1U);
    int expected = 0;
    ring.drain([&expected](int value) { EXPECT_EQ(value, expected++); });
    EXPECT_EQ(expected, 4);
}

TEST(SampleRing, RejectsACapacityThatIsNotAPowerOfTwo) {
    EXPECT_THROW(SampleRing<int>(0), std::invalid_argument);
    EXPECT_THROW(SampleRing<int>(6), std::invalid_argument);
    EXPECT_NO_THROW(SampleRing<int>(1));
}

} // namespace
} // namespace springdrive
