// Covers base/cancellation.h, and how base/parallel.h passes on the cancellation.
#include "base/cancellation.h"
#include "base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>

namespace springdrive {
namespace {

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
