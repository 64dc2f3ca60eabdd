// Covers RestartPolicy of app/exhibit/supervisor.cpp; its processes are in the tests of the window.
#include "app/exhibit/lost_display.h"
#include "app/exhibit/supervisor.h"

#include <gtest/gtest.h>

namespace springdrive::app::exhibit {
namespace {

constexpr double kShort_s = RestartPolicy::kProven_s - 0.1;
constexpr double kLong_s = RestartPolicy::kProven_s + 0.1;

TEST(ExhibitRestart, NotAfterTheEndThatWasAskedFor) {
    RestartPolicy policy;
    EXPECT_FALSE(policy.pause_s({0, kShort_s}));
    EXPECT_FALSE(policy.pause_s({0, 8.0 * 3600.0}));
}

TEST(ExhibitRestart, NotOfAMistakenStart) {
    for (const int status : {1, 2}) {
        EXPECT_FALSE(RestartPolicy().pause_s({status, kShort_s}));
        RestartPolicy proven;
        EXPECT_TRUE(proven.pause_s({status, kLong_s}));
        EXPECT_TRUE(proven.pause_s({status, kShort_s})); // "no display" until it is back
    }
}

TEST(ExhibitRestart, OfEverythingElseAlsoAtOnce) {
    for (const int status : {kStartAgain, kLostDisplay, 128 + 11, 128 + 6, 128 + 9}) {
        EXPECT_EQ(RestartPolicy().pause_s({status, kShort_s}), RestartPolicy::kFirst_s) << status;
    }
}

TEST(ExhibitRestart, PausesLongerWhileItDiesAtOnce) {
    RestartPolicy policy;
    double before_s = 0.0;
    double waited_s = 0.0;
    for (int i = 0; i < 20; ++i) {
        const std::optional<double> pause_s = policy.pause_s({128 + 11, kShort_s});
        ASSERT_TRUE(pause_s);
        EXPECT_TRUE(*pause_s == 2.0 * before_s || *pause_s == RestartPolicy::kLongest_s || i == 0);
        before_s = *pause_s;
        waited_s += *pause_s;
    }
    EXPECT_EQ(before_s, RestartPolicy::kLongest_s);
    EXPECT_GT(waited_s, 13.0 * RestartPolicy::kLongest_s);
    EXPECT_EQ(policy.pause_s({128 + 11, kLong_s}), RestartPolicy::kFirst_s);
    EXPECT_EQ(policy.pause_s({128 + 11, kShort_s}), 2.0 * RestartPolicy::kFirst_s);
}

} // namespace
} // namespace springdrive::app::exhibit
