// Random faults of the board and its link: each is named as documented, and none reaches the motors
// as force above the limits.
#include "tests/usb/fault_storm.h"

#include "tests/support/cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>

namespace springdrive::usb {
namespace {

constexpr std::uint64_t kStormSeed = 74'000'000;

TEST(FaultStorm, EachFaultIsNamedAndHarmless) {
    const int number = testing::cases(60, 1000);
    std::map<std::string, int> summaries;
    double largest_A = 0.0;
    double largest_share = 0.0;
    for (int i = 0; i < number; ++i) {
        const testing::StormCase what = testing::random_storm_case(kStormSeed, i);
        const testing::StormOutcome outcome = testing::outcome_of(what);
        EXPECT_EQ(outcome.broken, "") << i << ": " << what.description();
        EXPECT_EQ(testing::misnaming(what, outcome), "") << i << ": " << what.description();
        ++summaries[testing::summary(what, outcome)];
        largest_A = std::max(largest_A, outcome.largest_A);
        largest_share = std::max(largest_share, outcome.largest_share);
    }
    std::string all;
    for (const auto &[summary, count] : summaries) {
        all += summary + " " + std::to_string(count) + "; ";
    }
    RecordProperty("outcomes", all);
    RecordProperty("largest_current_A", std::to_string(largest_A));
    RecordProperty("largest_share_of_force", std::to_string(largest_share));
}

} // namespace
} // namespace springdrive::usb
