// Covers engine/lab/limits/wall_tune.cpp.
#include "engine/lab/limits/wall_tune.h"

#include "engine/lab/limits/stability_simulation.h"
#include "engine/lab/loops/tip_stiffness.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>

namespace springdrive::limits {
namespace {

constexpr double kMargin = 1.3;

loops::StabilityCase late_servo() {
    loops::StabilityCase which;
    which.device = testing::phantom_1_0();
    which.delay_periods = 1;
    which.hands = {loops::no_hand(), loops::hand_of_firmness(0.5)};
    return which;
}

loops::StabilityCase with(const TunedWall &tuned, double factor) {
    loops::StabilityCase which = late_servo();
    which.drive = device::AmplifierKind::current_drive;
    which.tuning.lambda_rad_per_s = tuned.lambda_rad_per_s;
    which.wall = {factor * tuned.wall.stiffness_N_per_m, factor * tuned.wall.damping_Ns_per_m};
    return which;
}

bool holds(loops::StabilityCase which) {
    which.freedom = loops::Freedom::one_motor;
    const bool each = loops::is_stable(which);
    which.freedom = loops::Freedom::three_motors;
    return each && loops::is_stable(which);
}

TEST(TunedWall, LeavesItsMarginAndNoMore) {
    const TunedWall tuned = tuned_wall(late_servo(), kMargin);
    ASSERT_GT(tuned.wall.stiffness_N_per_m, 100.0);
    EXPECT_TRUE(holds(with(tuned, 1.0)));
    EXPECT_TRUE(holds(with(tuned, 0.999 * kMargin)));
    // With K alone a tenth larger the margin is lost: it is the largest with its B and λ.
    loops::StabilityCase stiffer = with(tuned, kMargin);
    stiffer.wall.stiffness_N_per_m *= 1.1;
    EXPECT_FALSE(holds(stiffer));
    EXPECT_TRUE(is_stable_simulated(with(tuned, 1.0),
                                    TrialOptions::with(SimulationEffects::electronics())));
}

/// Over an independent grid: no combination of K, B and λ exceeds it by more than the spacing of
/// its own grid.
TEST(TunedWall, IsTheStiffest) {
    const TunedWall tuned = tuned_wall(late_servo(), kMargin);
    for (int i = 0; i < 14; ++i) {
        const double B = std::pow(1.35, i); // up to 50
        for (int j = 0; j < 5; ++j) {
            const double lambda = 150.0 * std::pow(2.4, j); // up to 5000
            const TunedWall alternative{{1.06 * tuned.wall.stiffness_N_per_m, B}, lambda};
            EXPECT_FALSE(holds(with(alternative, kMargin))) << "B " << B << " λ " << lambda;
        }
    }
}

TEST(TunedWall, RespectsTheLimitOnTheForceOfACount) {
    const double large_N = loops::force_of_a_count_N(with(tuned_wall(late_servo(), kMargin), 1.0));
    const TunedWall quiet = tuned_wall(late_servo(), kMargin, 0.25 * large_N);
    ASSERT_GT(quiet.wall.stiffness_N_per_m, 0.0);
    EXPECT_LE(loops::force_of_a_count_N(with(quiet, 1.0)), 0.25 * large_N);
    EXPECT_TRUE(holds(with(quiet, kMargin)));
}

} // namespace
} // namespace springdrive::limits
