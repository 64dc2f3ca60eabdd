// Random faults of the board and its link: each is named as documented, and none makes a true force
// or speed above the limits.
#include "tests/usb/fault_storm.h"

#include "tests/support/cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <map>
#include <string>

namespace springdrive::usb {
namespace {

constexpr std::uint64_t kStormSeed = 74'000'000;

TEST(FaultStorm, EachFaultIsNamedAndHarmless) {
    const int number = testing::cases(60, 1000);
    std::map<std::string, int> summaries;
    double largest_A = 0.0;
    double largest_m_per_s = 0.0;
    double longest_over_s = -1.0;
    std::string worst;
    for (int i = 0; i < number; ++i) {
        const testing::StormCase what = testing::random_storm_case(kStormSeed, i);
        const testing::StormOutcome outcome = testing::outcome_of(what);
        EXPECT_EQ(outcome.broken, "") << i << ": " << what.description();
        EXPECT_EQ(testing::misnaming(what, outcome), "") << i << ": " << what.description();
        ++summaries[testing::summary(what, outcome)];
        largest_A = std::max(largest_A, outcome.largest_A);
        largest_m_per_s = std::max(largest_m_per_s, outcome.largest_m_per_s);
        if (outcome.longest_over_s > longest_over_s) {
            longest_over_s = outcome.longest_over_s;
            worst = fmt::format("{}: {:.2f} N, above the limit for {:.2f} ms; {}", i,
                                outcome.largest_N, 1e3 * longest_over_s, what.description());
        }
    }
    std::string all;
    for (const auto &[summary, count] : summaries) {
        all += summary + " " + std::to_string(count) + "; ";
    }
    RecordProperty("outcomes", all);
    RecordProperty("largest_current_A", std::to_string(largest_A));
    RecordProperty("largest_m_per_s", std::to_string(largest_m_per_s));
    RecordProperty("worst", worst);
    fmt::print("worst of {}: {}; {:.3f} m/s\n{}\n", number, worst, largest_m_per_s, all);
}

} // namespace
} // namespace springdrive::usb
