// Covers what threads exchange: base/hand_over.h, with its two threads; base/background.h and
// base/cancellation.h, and how base/parallel.h passes on the cancellation.
#include "base/hand_over.h"

#include "base/background.h"
#include "base/cancellation.h"
#include "base/parallel.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <future>
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

template <typename Result> Result waited_for(Background<Result> &background) {
    std::optional<Result> result;
    while (!(result = background.take())) {
        std::this_thread::yield();
    }
    return *result;
}

TEST(Background, GivesItsResultOnce) {
    Background<int> background;
    EXPECT_FALSE(background.is_busy());
    background.start([](BackgroundTalk &talk) {
        talk.share = 0.5;
        return 42;
    });
    EXPECT_TRUE(background.is_busy());
    EXPECT_EQ(waited_for(background), 42);
    EXPECT_FALSE(background.is_busy());
    EXPECT_FALSE(background.take());
    EXPECT_EQ(background.share(), 0.5);
}

TEST(Background, RethrowsTheWorksException) {
    Background<int> background;
    background.start([](BackgroundTalk &) -> int { throw std::runtime_error("no"); });
    EXPECT_THROW(waited_for(background), std::runtime_error);
    EXPECT_FALSE(background.is_busy());
}

TEST(Background, TellsTheWorkThatItIsCancelled) {
    const auto ended = std::make_shared<std::promise<bool>>();
    std::future<bool> was_requested = ended->get_future();
    {
        Background<int> background;
        background.start([ended](BackgroundTalk &talk) {
            while (talk.is_needed()) {
                std::this_thread::yield();
            }
            ended->set_value(talk.is_needed());
            return 0;
        });
    }
    EXPECT_FALSE(was_requested.get());
}

TEST(Background, ReportsTheWorksProgress) {
    Background<int> background;
    EXPECT_EQ(background.what(), "");
    background.start([](BackgroundTalk &talk) {
        talk.report("halves", 0.5);
        return 2;
    });
    EXPECT_EQ(waited_for(background), 2);
    EXPECT_EQ(background.what(), "halves");
    EXPECT_EQ(background.share(), 0.5);
}

TEST(Background, WorkAskedToEndEndsAtItsNextReport) {
    Background<int> background;
    background.start([](BackgroundTalk &talk) -> int {
        for (;;) {
            talk.report("no end of it", 0.0);
            std::this_thread::yield();
        }
    });
    background.ask_to_end();
    EXPECT_TRUE(background.is_busy()); // until the result is taken
    EXPECT_THROW(waited_for(background), std::runtime_error);
    EXPECT_FALSE(background.is_busy());
}

TEST(Background, NewWorkReplacesTheOld) {
    Background<int> background;
    background.start([](BackgroundTalk &talk) {
        while (talk.is_needed()) {
            std::this_thread::yield();
        }
        return 1;
    });
    background.start([](BackgroundTalk &) { return 2; });
    EXPECT_EQ(waited_for(background), 2);
}

TEST(Background, CancellingDoesNotWaitButTheDestructorDoes) {
    std::atomic<int> ended{0};
    std::atomic<bool> may_end{false};
    {
        Background<int> background;
        for (int i = 0; i < 3; ++i) { // two are cancelled while the third runs
            background.start([&](BackgroundTalk &talk) {
                while (talk.is_needed() || !may_end) {
                    std::this_thread::yield();
                }
                ++ended;
                return 0;
            });
        }
        EXPECT_EQ(ended, 0);
        may_end = true;
    }
    EXPECT_EQ(ended, 3);
}

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

TEST(Wanted, WorkWithoutAFlagContinues) { EXPECT_NO_THROW(stop_if_given_up()); }

TEST(Wanted, CancelledWorkEndsAtTheNextCheck) {
    std::atomic<bool> is_cancelled{false};
    const StopScope by(&is_cancelled);
    EXPECT_NO_THROW(stop_if_given_up());
    is_cancelled = true;
    EXPECT_THROW(stop_if_given_up(), Cancelled);
    {
        const StopScope without_hand(nullptr);
        EXPECT_NO_THROW(stop_if_given_up());
    }
    EXPECT_THROW(stop_if_given_up(), Cancelled);
}

TEST(Wanted, HelperThreadsShareTheFlag) {
    std::atomic<bool> is_cancelled{false};
    const StopScope by(&is_cancelled);
    std::atomic<std::size_t> done{0};
    EXPECT_THROW(for_each_in_parallel(100'000, 3,
                                      [&](std::size_t) {
                                          if (++done == 1000) {
                                              is_cancelled = true;
                                          }
                                      }),
                 Cancelled);
    EXPECT_LT(done, 50'000U);
    std::atomic<int> looked{0};
    EXPECT_THROW(in_chunks(3, 3,
                           [&](unsigned, std::size_t, std::size_t) {
                               ++looked;
                               stop_if_given_up();
                           }),
                 Cancelled);
    EXPECT_EQ(looked, 3);
}

} // namespace
} // namespace springdrive
