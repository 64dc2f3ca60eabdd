// Covers engine/lab/limits/stability_simulation.cpp.
#include "engine/lab/limits/stability_simulation.h"

#include "base/bisection.h"
#include "tests/support/random_loops.h"
#include "tests/support/stability_cases.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace springdrive::limits {
namespace {

/// One motor with the tuning "firm", without a hand and with that K_P.
loops::StabilityCase with_K_P(double K_P_V_per_rad) {
    loops::StabilityCase which = testing::firm();
    which.hands = {loops::no_hand()};
    which.tuning.K_P_V_per_rad = K_P_V_per_rad;
    return which;
}

const loops::LoopMember kThird{2, loops::no_hand()};

TEST(StabilitySimulation, GrowsAndDecaysAtTheRateOfTheEigenvalue) {
    std::mt19937_64 random(21);
    int stable = 0;
    int unstable = 0;
    for (int compared = 0; compared < 30;) {
        const loops::StabilityCase which = testing::random_rotor_loop(random);
        const loops::LoopMember member = loops::members(which).front();
        // Of the slowest mode [1/s].
        const double truth = std::log(loops::largest_eigenvalue(which, member)) / which.period_s;
        const Trial trial = simulated(which, member, TrialOptions::linear());
        if (std::abs(truth) > 0.5) {
            EXPECT_EQ(trial.stable, truth < 0.0)
                << "growth " << truth << "/s, T " << which.period_s;
            ++(truth < 0.0 ? stable : unstable);
        }
        if (std::abs(truth) <= 3.0) { // others end before the slowest mode dominates
            // Sub-steps of 50 µs have 1e-3 of phase; windows sample the crests of slow modes
            // unevenly.
            EXPECT_NEAR(trial.growth_per_s, truth, 0.1 + 0.05 * std::abs(truth));
            EXPECT_EQ(trial.stable, trial.growth_per_s < 0.0);
            ++compared;
        }
    }
    EXPECT_GT(stable, 20);
    EXPECT_GT(unstable, 20);
}

TEST(StabilitySimulation, AnyRateAndDelay) {
    for (const double period_s : {1e-4, 1e-3, 0.0123, 0.05}) {
        for (const int delay : {0, 3, 8}) {
            loops::StabilityCase which = testing::firm();
            which.period_s = period_s;
            which.delay_periods = delay;
            which.hands = {loops::no_hand()};
            // Slow enough in position for any of them: a soft spring on a heavy rotor.
            which.rotor = device::RotorLoad{1e-3, 1e-3, 0.0};
            which.tuning.K_D_Vs_per_rad = 0.0;
            which.tuning.dR_Ohm = 2.0;
            for (const double K_P : {0.02, 50.0}) {
                which.tuning.K_P_V_per_rad = K_P;
                const loops::LoopMember member = loops::members(which).front();
                EXPECT_EQ(simulated(which, member, TrialOptions::linear()).stable,
                          loops::largest_eigenvalue(which, member) < 1.0)
                    << period_s << " s, delay " << delay << ", K_P " << K_P;
            }
        }
    }
}

/// Where the links are perpendicular, three motors under the inverse map are three independent
/// motors.
TEST(StabilitySimulation, ThreeMotorsAreThreeTimesOneWhereTheyAreDecoupled) {
    TrialOptions options = TrialOptions::linear();
    options.longest_s = 0.6;
    loops::StabilityCase one = with_K_P(0.0);
    one.q_rad = {0.0, 0.1, 0.1};
    one.tuning.map = control::MotionMap::inverse;
    const double limit = last_that_holds({1.0, 200.0}, 1e-4, [&](double K_P) {
        one.tuning.K_P_V_per_rad = K_P;
        return loops::is_stable(one);
    });
    for (const double share : {0.97, 1.03}) {
        one.tuning.K_P_V_per_rad = share * limit;
        loops::StabilityCase three = one;
        three.freedom = loops::Freedom::three_motors;
        EXPECT_EQ(loops::is_stable(three), share < 1.0);
        EXPECT_EQ(is_stable_simulated(one, options), share < 1.0);
        EXPECT_EQ(is_stable_simulated(three, options), share < 1.0);
    }
}

TEST(StabilitySimulation, EveryMemberCounts) {
    loops::StabilityCase which = testing::firm();
    which.tuning.K_P_V_per_rad = 29.5; // just stable
    EXPECT_TRUE(is_stable_simulated(which, TrialOptions::linear()));
    which.tuning.K_P_V_per_rad = 30.5; // unstable without a hand, stable with a firm one
    EXPECT_FALSE(is_stable_simulated(which, TrialOptions::linear()));
    which.hands = {loops::hand_of_firmness(1.0)};
    EXPECT_TRUE(is_stable_simulated(which, TrialOptions::linear()));
}

TEST(StabilitySimulation, AtTheLimitAMotionPersists) {
    const double limit = last_that_holds({1.0, 200.0}, 1e-6, [](double K_P) {
        return loops::largest_eigenvalue(with_K_P(K_P), kThird) < 1.0;
    });
    const auto stays = [&](double share) {
        return simulated(with_K_P(share * limit), kThird, TrialOptions::linear()).stays;
    };
    // Sub-steps of 50 µs move the simulated limit by some 1e-4: (ωh)²/12 of its phase.
    bool somewhere = false;
    for (double share = 0.999; share < 1.001 && !somewhere; share += 1e-4) {
        somewhere = stays(share);
    }
    EXPECT_TRUE(somewhere);
    EXPECT_FALSE(stays(0.98));
    EXPECT_FALSE(stays(1.02));
}

TEST(StabilitySimulation, RestsOnItsCountsBeforeTheObservationEnds) {
    loops::StabilityCase which = testing::firm();
    which.freedom = loops::Freedom::three_motors;
    const loops::LoopMember member{0, loops::no_hand()};
    const TrialOptions options = TrialOptions::with(SimulationEffects::electronics());
    EXPECT_TRUE(simulated(which, member, options).stable);
    // Even where the run is too short to measure a slope.
    TrialOptions brief = options;
    brief.longest_s = 0.7;
    brief.extension_s = 0.0;
    EXPECT_TRUE(simulated(which, member, brief).stable);
}

TEST(StabilitySimulation, CountsSustainVibrationOfALoopWithLittleDamping) {
    const auto rests = [](const TrialOptions &options) {
        return simulated(with_K_P(29.5), kThird, options).stable;
    };
    EXPECT_TRUE(rests(TrialOptions::linear()));
    EXPECT_FALSE(rests(TrialOptions::with(SimulationEffects::electronics())));
    EXPECT_TRUE(rests(TrialOptions::with(SimulationEffects::all())));
}

TEST(StabilitySimulation, SaturationBoundsADivergingMotion) {
    const loops::StabilityCase which = with_K_P(60.0);
    EXPECT_FALSE(simulated(which, kThird, TrialOptions::linear()).stable);
    const Trial bound =
        simulated(which, kThird, TrialOptions::with(SimulationEffects::electronics()));
    EXPECT_FALSE(bound.stable);
    EXPECT_LT(bound.growth_per_s, 1.0);
    // Not faster than the supply allows a motor to run.
    EXPECT_LT(bound.last_rate_rad_per_s,
              which.device.motor[2].supply_V / which.device.motor[2].torque_constant_Nm_per_A);
}

/// A push of a hundredth of a newton is less than the joints' friction of 0.04 N, and far from the
/// supply limits. So friction alone prevents motion, and limits alone change nothing.
TEST(StabilitySimulation, EachEffectIsTheRequestedOne) {
    loops::StabilityCase which = testing::firm();
    for (const loops::Freedom freedom : {loops::Freedom::one_motor, loops::Freedom::three_motors}) {
        which.freedom = freedom;
        const auto after_a_nudge = [&](const SimulationEffects &effects) {
            return simulated(which, kThird, {effects, 1e-6, 0.02, 0.0});
        };
        const Trial plain = after_a_nudge(SimulationEffects::none());
        const Trial limited = after_a_nudge({.saturation = true});
        const Trial sticky = after_a_nudge({.friction = true});
        EXPECT_GT(plain.last_rate_rad_per_s, 0.0);
        EXPECT_EQ(limited.last_rate_rad_per_s, plain.last_rate_rad_per_s);
        EXPECT_EQ(sticky.last_rate_rad_per_s, 0.0);
    }
}

TEST(StabilitySimulation, WithExtremeGainsItDoesNotRest) {
    loops::StabilityCase which = with_K_P(1e4);
    // At a period as long as the observation of a flicker, a single sample would show none.
    which.period_s = 0.2;
    ASSERT_GT(loops::largest_eigenvalue(which, kThird), 2.0);
    const TrialOptions counts = TrialOptions::with(SimulationEffects::electronics());
    EXPECT_FALSE(simulated(which, loops::members(which).front(), counts).stable);
    which.period_s = 1e-3;
    which.tuning.K_D_Vs_per_rad = 10.0;
    for (const loops::Freedom freedom : {loops::Freedom::one_motor, loops::Freedom::three_motors}) {
        which.freedom = freedom;
        EXPECT_FALSE(is_stable_simulated(which, TrialOptions::linear()));
        EXPECT_FALSE(is_stable_simulated(which, counts));
    }
}

} // namespace
} // namespace springdrive::limits
