// Covers engine/lab/limits/method_limits/late_ticks.cpp.
#include "engine/lab/limits/method_limits/late_ticks.h"

#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>

namespace springdrive::limits {
namespace {

loops::StabilityCase three_motors_in_a_hand() {
    loops::StabilityCase which;
    which.device = testing::phantom_1_0();
    which.freedom = loops::Freedom::three_motors;
    which.hands = {loops::hand_of_firmness(0.5)};
    return which;
}

TEST(LateTicks, WithoutLatenessAreTwoTicksOfThePlainLoop) {
    loops::StabilityCase which = three_motors_in_a_hand();
    for (const double K_P : {1.0, 6.0, 25.0, 60.0}) {
        which.tuning.K_P_V_per_rad = K_P;
        const loops::LoopMember member = loops::members(which).front();
        const double once = loops::largest_eigenvalue(which, member);
        // Double roots are accurate to half of the digits.
        EXPECT_NEAR(late_ticks_eigenvalue(which, member, 0), once * once, 1e-7) << K_P;
    }
}

TEST(LateTicks, LoseStabilityLaterWithSofterGains) {
    const auto max_missed = [](double K_P) {
        loops::StabilityCase which = three_motors_in_a_hand();
        which.tuning.K_P_V_per_rad = K_P;
        int missed = 0;
        while (missed < 200 &&
               late_ticks_eigenvalue(which, loops::members(which).front(), missed + 1) < 1.0) {
            ++missed;
        }
        return missed;
    };
    const int soft = max_missed(3.0);
    const int firm = max_missed(6.0);
    const int hard = max_missed(12.0);
    EXPECT_GT(soft, firm);
    EXPECT_GT(firm, hard);
    EXPECT_GT(hard, 0);
}

} // namespace
} // namespace springdrive::limits
