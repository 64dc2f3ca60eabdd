// Covers base/wanted.h, and how base/parallel.h passes on the cancellation.
#include "base/parallel.h"
#include "base/wanted.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>

namespace springdrive {
namespace {

TEST(Wanted, WorkWithoutAFlagContinues) { EXPECT_NO_THROW(stop_if_given_up()); }

TEST(Wanted, CancelledWorkEndsAtTheNextCheck) {
    std::atomic<bool> is_given_up{false};
    const GivenUpBy by(&is_given_up);
    EXPECT_NO_THROW(stop_if_given_up());
    is_given_up = true;
    EXPECT_THROW(stop_if_given_up(), NotWanted);
    {
        const GivenUpBy without_hand(nullptr);
        EXPECT_NO_THROW(stop_if_given_up());
    }
    EXPECT_THROW(stop_if_given_up(), NotWanted);
}

TEST(Wanted, HelperThreadsShareTheFlag) {
    std::atomic<bool> is_given_up{false};
    const GivenUpBy by(&is_given_up);
    std::atomic<std::size_t> done{0};
    EXPECT_THROW(for_each_in_parallel(100'000, 3,
                                      [&](std::size_t) {
                                          if (++done == 1000) {
                                              is_given_up = true;
                                          }
                                      }),
                 NotWanted);
    EXPECT_LT(done, 50'000U);
    std::atomic<int> looked{0};
    EXPECT_THROW(in_chunks(3, 3,
                           [&](unsigned, std::size_t, std::size_t) {
                               ++looked;
                               stop_if_given_up();
                           }),
                 NotWanted);
    EXPECT_EQ(looked, 3);
}

} // namespace
} // namespace springdrive
