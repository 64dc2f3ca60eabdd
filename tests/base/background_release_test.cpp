// Covers base/background.h.
#include "base/background.h"

#include <gtest/gtest.h>

#include <atomic>

namespace springdrive {
namespace {

std::atomic<int> alive{0};
std::atomic<bool> may_go{false};

struct Heavy {
    Heavy() { ++alive; }
    ~Heavy() {
        may_go.wait(false);
        --alive;
    }
    Heavy(const Heavy &) = delete;
    Heavy &operator=(const Heavy &) = delete;
};

TEST(BackgroundRelease, ReleasesAllWithoutBlockingTheCaller) {
    {
        BackgroundRelease<Heavy> release;
        for (int i = 0; i < 20; ++i) {
            release.let_go(std::make_unique<Heavy>());
        }
        EXPECT_EQ(alive, 20); // reached although none can have been destroyed
        may_go = true;
        may_go.notify_all();
    }
    EXPECT_EQ(alive, 0); // joined
}

TEST(BackgroundRelease, EndsImmediatelyWithNothingToRelease) {
    const BackgroundRelease<Heavy> release;
    EXPECT_EQ(alive, 0);
}

} // namespace
} // namespace springdrive
