// Covers engine/lab/limits/simulated_limit.cpp.
#include "engine/lab/limits/simulated_limit.h"

#include "tests/support/random_loops.h"
#include "tests/support/stability_cases.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string_view>

namespace springdrive::limits {
namespace {

StabilityLimit predicted(const loops::StabilityCase &which,
                         const loops::StabilityParameter &parameter) {
    return predicted_limits(which, parameter, {parameter.from, parameter.to}).front();
}

TEST(SimulatedLimit, HasAllMembersStableAndOneThatIsNotBeyond) {
    const loops::StabilityParameter &kp = testing::named("kp");
    const StabilityLimit limit = predicted(testing::firm(), kp);
    for (const TrialOptions &options :
         {TrialOptions::linear(), TrialOptions::with(SimulationEffects::electronics()),
          TrialOptions::with(SimulationEffects::all())}) {
        const std::optional<double> found = simulated_limit(testing::firm(), kp, limit, options);
        ASSERT_TRUE(found);
        EXPECT_TRUE(is_stable_simulated(testing::with(testing::firm(), kp, *found), options));
        // To 1e-3 of the larger end of the bracket; trials are deterministic.
        bool fails = false;
        for (const double beyond : {1.0005, 1.0011, 1.002}) {
            fails = fails || !is_stable_simulated(
                                 testing::with(testing::firm(), kp, beyond * *found), options);
        }
        EXPECT_TRUE(fails);
    }
}

/// With counts a loop rests, vibrates and rests again along T. All of a grid below the limit rest.
TEST(SimulatedLimit, WithCountsIsTheFirstFromTheStableSide) {
    const loops::StabilityParameter &T = testing::named("T");
    const TrialOptions options = TrialOptions::with(SimulationEffects::electronics());
    const StabilityLimit limit = predicted(testing::firm(), T);
    const std::optional<double> found = simulated_limit(testing::firm(), T, limit, options);
    ASSERT_TRUE(found);
    for (const double share : {0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 1.0}) {
        const double value = share * limit.predicted;
        if (value < *found) {
            EXPECT_TRUE(is_stable_simulated(testing::with(testing::firm(), T, value), options))
                << share;
        } else { // the first beyond it does not
            EXPECT_FALSE(is_stable_simulated(testing::with(testing::firm(), T, value), options))
                << share;
            break;
        }
    }
    // Some values farther out rest.
    bool rests_again = false;
    for (double value = 1.01 * *found; value < limit.predicted && !rests_again; value *= 1.01) {
        rests_again = is_stable_simulated(testing::with(testing::firm(), T, value), options);
    }
    EXPECT_TRUE(rests_again);
}

/// The results are those of the trials: with a wrong prediction the same limit is found.
TEST(SimulatedLimit, IsIndependentOfThePrediction) {
    const loops::StabilityParameter &kp = testing::named("kp");
    loops::StabilityCase which = testing::firm();
    which.hands = {loops::no_hand()};
    const StabilityLimit truth = predicted(which, kp);
    for (const double wrong_by : {0.6, 0.9, 1.1, 1.6}) {
        StabilityLimit wrong = truth;
        wrong.predicted *= wrong_by;
        const std::optional<double> found =
            simulated_limit(which, kp, wrong, TrialOptions::linear());
        ASSERT_TRUE(found) << wrong_by;
        EXPECT_NEAR(*found, truth.predicted, 5e-3 * truth.predicted) << wrong_by;
    }
}

TEST(SimulatedLimit, WorksForALowerLimitToo) {
    const loops::StabilityParameter &dR = testing::named("dR");
    loops::StabilityCase which = testing::firm();
    which.hands = {loops::no_hand()};
    const StabilityLimit limit = predicted(which, dR);
    ASSERT_FALSE(limit.stable_below);
    const std::optional<double> linear = simulated_limit(which, dR, limit, TrialOptions::linear());
    ASSERT_TRUE(linear);
    EXPECT_NEAR(*linear, limit.predicted, 5e-3 * limit.predicted);
    const std::optional<double> counts =
        simulated_limit(which, dR, limit, TrialOptions::with(SimulationEffects::electronics()));
    ASSERT_TRUE(counts);
    EXPECT_GT(*counts, limit.predicted); // earlier: counts sustain vibration
}

TEST(SimulatedLimit, OfADelayHasItsSides) {
    const loops::StabilityParameter &d = testing::named("d");
    const StabilityLimit limit = predicted(testing::firm(), d);
    for (const TrialOptions &options :
         {TrialOptions::linear(), TrialOptions::with(SimulationEffects::all())}) {
        const std::optional<double> found = simulated_limit(testing::firm(), d, limit, options);
        ASSERT_TRUE(found);
        EXPECT_TRUE(is_stable_simulated(testing::with(testing::firm(), d, *found), options));
        // Bisection to 1e-3.
        EXPECT_FALSE(
            is_stable_simulated(testing::with(testing::firm(), d, *found * 1.002), options));
    }
}

TEST(SimulatedLimit, MayNotExist) {
    // Friction holds the device at a soft wall, far beyond the limit.
    loops::StabilityCase which = testing::firm();
    which.drive = device::AmplifierKind::current_drive;
    which.hands = {loops::no_hand()};
    const loops::StabilityParameter &K = testing::named("wall-stiffness");
    EXPECT_FALSE(simulated_limit(which, K, predicted(which, K),
                                 TrialOptions::with(SimulationEffects::all())));
}

/// A soft wall without damping, the whole linkage: all modes are slow, and the one that grows is
/// masked by the others at first. Observed for half a minute.
TEST(SimulatedLimit, IsNearForSlowMotionsToo) {
    loops::StabilityCase which = testing::firm();
    which.drive = device::AmplifierKind::current_drive;
    which.freedom = loops::Freedom::three_motors;
    which.hands = {loops::no_hand()};
    const loops::StabilityParameter &K = testing::named("wall-stiffness");
    const StabilityLimit limit = predicted(which, K);
    TrialOptions short_watch = TrialOptions::linear();
    short_watch.extension_s = 0.0;
    const TrialOptions patient = TrialOptions::linear();
    // Grows by 0.056/s 1.2 times as stiff, beside two that fall by 0.11 and 0.21/s (eigenvalues).
    const loops::StabilityCase beyond = testing::with(which, K, 1.2 * limit.predicted);
    EXPECT_TRUE(is_stable_simulated(beyond, short_watch));
    EXPECT_FALSE(is_stable_simulated(beyond, patient));
    EXPECT_TRUE(is_stable_simulated(testing::with(which, K, 0.98 * limit.predicted), patient));
}

} // namespace
} // namespace springdrive::limits
