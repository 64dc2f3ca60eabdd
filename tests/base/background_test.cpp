// Covers base/background.h.
#include "base/background.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <stdexcept>

namespace springdrive {
namespace {

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
    std::future<bool> was_wanted = ended->get_future();
    {
        Background<int> background;
        background.start([ended](BackgroundTalk &talk) {
            while (talk.is_wanted()) {
                std::this_thread::yield();
            }
            ended->set_value(talk.is_wanted());
            return 0;
        });
    }
    EXPECT_FALSE(was_wanted.get());
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
        while (talk.is_wanted()) {
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
                while (talk.is_wanted() || !may_end) {
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

} // namespace
} // namespace springdrive
