// Covers base/background_release.h.
#include "base/background_release.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>

namespace springdrive {
namespace {

std::atomic<int> alive{0};

struct Heavy {
    Heavy() { ++alive; }
    ~Heavy() {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        --alive;
    }
    Heavy(const Heavy &) = delete;
    Heavy &operator=(const Heavy &) = delete;
};

TEST(BackgroundRelease, ReleasesAllWithoutMakingAnybodyWait) {
    {
        BackgroundRelease<Heavy> release;
        const auto start = std::chrono::steady_clock::now();
        for (int i = 0; i < 20; ++i) {
            release.let_go(std::make_unique<Heavy>());
        }
        EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(400));
        EXPECT_GT(alive, 0);
    }
    EXPECT_EQ(alive, 0); // joined
}

TEST(BackgroundRelease, WithNothingToReleaseEndsAtOnce) {
    const BackgroundRelease<Heavy> release;
    EXPECT_EQ(alive, 0);
}

} // namespace
} // namespace springdrive
