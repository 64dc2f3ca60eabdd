// Covers engine/lab/limits/stability_simulation.cpp.
#include "engine/lab/limits/stability_simulation.h"

#include "tests/support/random_loops.h"
#include "tests/support/stability_cases.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace springdrive::limits {
namespace {

/// Growth of the slowest mode [1/s], from its eigenvalue.
double predicted_growth_per_s(const loops::StabilityCase &which, const loops::LoopMember &member) {
    return std::log(loops::largest_eigenvalue(which, member)) / which.period_s;
}

TEST(StabilitySimulation, GrowsAndDecaysAtTheRateOfTheEigenvalue) {
    std::mt19937_64 random(21);
    int compared = 0;
    while (compared < 30) {
        const loops::StabilityCase which = testing::random_rotor_loop(random);
        const loops::LoopMember member = loops::members(which).front();
        const double truth = predicted_growth_per_s(which, member);
        if (std::abs(truth) > 3.0) { // these end before the slowest mode dominates
            continue;
        }
        ++compared;
        const Trial trial = simulated(which, member, TrialOptions::linear());
        // Sub-steps of 50 µs have 1e-3 of phase; windows sample the crests of slow modes unevenly.
        EXPECT_NEAR(trial.growth_per_s, truth, 0.1 + 0.05 * std::abs(truth));
        EXPECT_EQ(trial.stable, trial.growth_per_s < 0.0);
    }
}

TEST(StabilitySimulation, AgreesOnStabilityFarFromTheLine) {
    std::mt19937_64 random(22);
    int stable = 0;
    for (int i = 0; i < 150; ++i) {
        const loops::StabilityCase which = testing::random_rotor_loop(random);
        const loops::LoopMember member = loops::members(which).front();
        const double growth = predicted_growth_per_s(which, member);
        if (std::abs(growth) > 0.5) {
            EXPECT_EQ(simulated(which, member, TrialOptions::linear()).stable, growth < 0.0)
                << "growth " << growth << "/s, T " << which.period_s;
            stable += growth < 0.0 ? 1 : 0;
        }
    }
    EXPECT_GT(stable, 20);
    EXPECT_LT(stable, 148); // and some are not
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
    loops::StabilityCase three = testing::firm();
    three.q_rad = {0.0, 0.1, 0.1};
    three.tuning.map = control::MotionMap::inverse;
    three.hands = {loops::no_hand()};
    loops::StabilityCase one = three;
    three.freedom = loops::Freedom::three_motors;
    TrialOptions options = TrialOptions::linear();
    options.longest_s = 0.6;
    const double K_P_limit = [&] {
        double stable = 1.0;
        double unstable = 200.0;
        while (unstable - stable > 1e-4 * stable) {
            const double middle = 0.5 * (stable + unstable);
            one.tuning.K_P_V_per_rad = middle;
            (loops::is_stable(one) ? stable : unstable) = middle;
        }
        return stable;
    }();
    for (const double share : {0.97, 1.03}) {
        three.tuning.K_P_V_per_rad = one.tuning.K_P_V_per_rad = share * K_P_limit;
        const bool truth = share < 1.0;
        EXPECT_EQ(loops::is_stable(three), truth);
        EXPECT_EQ(is_stable_simulated(one, options), truth);
        EXPECT_EQ(is_stable_simulated(three, options), truth);
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
    loops::StabilityCase which = testing::firm();
    which.hands = {loops::no_hand()};
    const loops::LoopMember third{2, loops::no_hand()};
    double stable = 1.0;
    double unstable = 200.0;
    while (unstable - stable > 1e-6 * stable) {
        which.tuning.K_P_V_per_rad = 0.5 * (stable + unstable);
        (loops::largest_eigenvalue(which, third) < 1.0 ? stable : unstable) =
            which.tuning.K_P_V_per_rad;
    }
    // Sub-steps of 50 µs move the simulated limit by some 1e-4: (ωh)²/12 of its phase.
    bool stays = false;
    for (double share = 0.999; share < 1.001; share += 1e-4) {
        which.tuning.K_P_V_per_rad = share * stable;
        stays = stays || simulated(which, third, TrialOptions::linear()).stays;
    }
    EXPECT_TRUE(stays);
    for (const double share : {0.98, 1.02}) {
        which.tuning.K_P_V_per_rad = share * stable;
        EXPECT_FALSE(simulated(which, third, TrialOptions::linear()).stays);
    }
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
    loops::StabilityCase which = testing::firm();
    which.hands = {loops::no_hand()};
    which.tuning.K_P_V_per_rad = 29.5;
    const loops::LoopMember third{2, loops::no_hand()};
    EXPECT_TRUE(simulated(which, third, TrialOptions::linear()).stable);
    EXPECT_FALSE(
        simulated(which, third, TrialOptions::with(SimulationEffects::electronics())).stable);
    EXPECT_TRUE(simulated(which, third, TrialOptions::with(SimulationEffects::all())).stable);
}

TEST(StabilitySimulation, SaturationBoundsADivergingMotion) {
    loops::StabilityCase which = testing::firm();
    which.tuning.K_P_V_per_rad = 60.0;
    const loops::LoopMember member{2, loops::no_hand()};
    const Trial free = simulated(which, member, TrialOptions::linear());
    const Trial bound =
        simulated(which, member, TrialOptions::with(SimulationEffects::electronics()));
    EXPECT_FALSE(free.stable);
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
    const loops::LoopMember member{2, loops::no_hand()};
    for (const loops::Freedom freedom : {loops::Freedom::one_motor, loops::Freedom::three_motors}) {
        which.freedom = freedom;
        const auto after_a_nudge = [&](const SimulationEffects &effects) {
            return simulated(which, member, {effects, 1e-6, 0.02, 0.0});
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
    loops::StabilityCase which = testing::firm();
    which.hands = {loops::no_hand()};
    which.tuning.K_P_V_per_rad = 1e4;
    which.tuning.K_D_Vs_per_rad = 10.0;
    for (const loops::Freedom freedom : {loops::Freedom::one_motor, loops::Freedom::three_motors}) {
        which.freedom = freedom;
        EXPECT_FALSE(is_stable_simulated(which, TrialOptions::linear()));
        EXPECT_FALSE(
            is_stable_simulated(which, TrialOptions::with(SimulationEffects::electronics())));
    }
}

/// At a period as long as the observation of a flicker, a single sample would show none.
TEST(StabilitySimulation, ASlowServoWithAnOscillatingRotorDoesNotRest) {
    loops::StabilityCase which = testing::firm();
    which.hands = {loops::no_hand()};
    which.tuning.K_P_V_per_rad = 1e4;
    which.period_s = 0.2;
    const loops::LoopMember member = loops::members(which).front();
    ASSERT_GT(loops::largest_eigenvalue(which, member), 2.0);
    EXPECT_FALSE(
        simulated(which, member, TrialOptions::with(SimulationEffects::electronics())).stable);
}

} // namespace
} // namespace springdrive::limits
