// Covers engine/lab/limits/stability_limits.cpp; long_limits_test.cpp
// has the slow tests.
#include "engine/lab/limits/stability_limits.h"

#include "base/bisection.h"
#include "device/core/phantom/kinematics.h"
#include "engine/lab/limits/stability_simulation.h"
#include "tests/support/runge_kutta_loop.h"
#include "tests/support/stability_cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <string_view>
#include <vector>

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

ParameterRange whole_range(const loops::StabilityParameter &parameter) {
    return {parameter.from, parameter.to};
}

/// An independent bisection, by Runge-Kutta alone, from a factor 1.3 on both sides.
double limit_by_runge_kutta(const loops::StabilityCase &which,
                            const loops::StabilityParameter &parameter,
                            const StabilityLimit &near) {
    const auto dies_out = [&](double value) {
        return testing::RungeKuttaLoop(testing::with(which, parameter, value)).dies_out();
    };
    const double outward = near.stable_below ? 1.3 : 1.0 / 1.3;
    EXPECT_TRUE(dies_out(near.predicted / outward)) << parameter.name;
    EXPECT_FALSE(dies_out(near.predicted * outward)) << parameter.name;
    return last_that_holds({near.predicted / outward, near.predicted * outward}, 1e-3, dies_out);
}

TEST(StabilityLimits, AreWhereRungeKuttaFindsThem) {
    constexpr std::array kNames{"kp", "kd", "dR", "T"};
    std::mt19937_64 random(11);
    int found = 0;
    for (std::size_t i = 0; found < 6; ++i) {
        const loops::StabilityParameter &parameter = testing::named(kNames[i % kNames.size()]);
        loops::StabilityCase which = testing::random_rotor_loop(random);
        // Windings that are ten times as fast take Runge-Kutta ten times as long.
        if (which.tuning.dR_Ohm / which.device.motor[1].inductance_H > 5e3) {
            continue;
        }
        const std::vector<StabilityLimit> limits =
            predicted_limits(which, parameter, whole_range(parameter));
        if (limits.size() != 1) { // another one may be within the factor 1.3
            continue;
        }
        ++found;
        const double truth = limit_by_runge_kutta(which, parameter, limits.front());
        // Bisection to 1e-3, and the slow growth of a mode near the limit over 4400 periods.
        EXPECT_NEAR(limits.front().predicted, truth, 3e-3 * truth) << parameter.name;
        const std::optional<double> tried =
            simulated_limit(which, parameter, limits.front(), TrialOptions::linear());
        ASSERT_TRUE(tried) << parameter.name;
        EXPECT_NEAR(*tried, truth, 0.01 * truth) << parameter.name;
    }
}

TEST(StabilityLimits, ThePredictedOneHasAStableAndAnUnstableSide) {
    std::mt19937_64 random(12);
    int found = 0;
    for (int i = 0; found < 100; ++i) {
        const loops::StabilityParameter &parameter =
            loops::stability_parameters()[static_cast<std::size_t>(i) % 13]; // all but the wall's
        loops::StabilityCase which = testing::random_rotor_loop(random);
        for (const StabilityLimit &limit :
             predicted_limits(which, parameter, whole_range(parameter))) {
            ++found;
            EXPECT_TRUE(loops::is_stable(testing::with(which, parameter, limit.predicted)))
                << parameter.name;
            const double outward = limit.stable_below ? 1.0 : -1.0;
            const double beyond = limit.predicted * (1.0 + outward * 2e-6);
            EXPECT_FALSE(loops::is_stable(testing::with(which, parameter, beyond)))
                << parameter.name;
        }
    }
}

TEST(StabilityLimits, NamesTheMemberThatFailsFirst) {
    const loops::StabilityParameter &kp = testing::named("kp");
    const std::vector<StabilityLimit> limits =
        predicted_limits(testing::firm(), kp, whole_range(kp));
    ASSERT_EQ(limits.size(), 1U);
    // Each motor and hand alone: the smallest of their limits is that of all.
    double minimum = 1e9;
    loops::LoopMember who;
    for (const loops::LoopMember &member : loops::members(testing::firm())) {
        const double limit = last_that_holds({0.1, 1e4}, 1e-7, [&](double K_P) {
            return loops::largest_eigenvalue(testing::with(testing::firm(), kp, K_P), member) < 1.0;
        });
        if (limit < minimum) {
            minimum = limit;
            who = member;
        }
    }
    EXPECT_NEAR(limits.front().predicted, minimum, 2e-6 * minimum);
    EXPECT_EQ(limits.front().worst.motor, who.motor);
    EXPECT_EQ(limits.front().worst.hand.name, who.hand.name);
    EXPECT_TRUE(limits.front().stable_below);
}

TEST(StabilityLimits, ThereMayBeTwo) {
    // A filter may be too slow, and with K_D too fast.
    const loops::StabilityParameter &lambda = testing::named("lambda");
    std::mt19937_64 random(13);
    int twice = 0;
    for (int i = 0; i < 300 && twice == 0; ++i) {
        const loops::StabilityCase which = testing::random_rotor_loop(random);
        const std::vector<StabilityLimit> limits =
            predicted_limits(which, lambda, whole_range(lambda));
        if (limits.size() < 2) {
            continue;
        }
        ++twice;
        EXPECT_NE(limits[0].stable_below, limits[1].stable_below);
        EXPECT_LT(limits[0].predicted, limits[1].predicted);
    }
    EXPECT_EQ(twice, 1);
}

TEST(StabilityLimits, MayNotBeWithinTheRange) {
    EXPECT_TRUE(stability_limits(testing::firm(), testing::named("kp"), {0.1, 1.0}).empty());
    EXPECT_TRUE(stability_limits(testing::firm(), testing::named("kp"), {100.0, 200.0}).empty());
}

TEST(StabilityLimits, AZeroIsALimitToo) {
    // A winding alone, its rotor held by a stiff spring: it decays while dR > 0.
    loops::StabilityCase which = testing::firm();
    which.rotor = device::RotorLoad{1e-3, 6.3, 1e4};
    which.hands = {loops::no_hand()};
    which.tuning.K_P_V_per_rad = which.tuning.K_D_Vs_per_rad = 0.0;
    const std::vector<StabilityLimit> limits =
        predicted_limits(which, testing::named("dR"), {-1.0, 1.0});
    ASSERT_EQ(limits.size(), 1U);
    EXPECT_FALSE(limits.front().stable_below);
    EXPECT_NEAR(limits.front().predicted, 0.0, 1e-9);
}

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

/// A delay may be any number of periods: its limit lies between the stable and the unstable whole
/// number.
TEST(SimulatedLimit, OfADelayHasItsSides) {
    const loops::StabilityParameter &d = testing::named("d");
    const StabilityLimit limit = predicted(testing::firm(), d);
    const auto at = [&](double delay) { return testing::with(testing::firm(), d, delay); };
    EXPECT_TRUE(loops::is_stable(at(std::floor(limit.predicted))));
    EXPECT_FALSE(loops::is_stable(at(std::ceil(limit.predicted))));
    for (const TrialOptions &options :
         {TrialOptions::linear(), TrialOptions::with(SimulationEffects::all())}) {
        const std::optional<double> found = simulated_limit(testing::firm(), d, limit, options);
        ASSERT_TRUE(found);
        EXPECT_TRUE(is_stable_simulated(at(*found), options));
        EXPECT_FALSE(is_stable_simulated(at(*found * 1.002), options)); // bisection to 1e-3
        if (!options.effects.any()) {
            EXPECT_NEAR(*found, limit.predicted, 0.01 * limit.predicted);
        }
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

MapAxis axis(std::string_view name, double from, double to, int steps) {
    return {loops::stability_parameter_named(name), {from, to}, steps};
}

TrialOptions of_a_map() {
    TrialOptions options = TrialOptions::with(SimulationEffects::electronics());
    options.longest_s = 1.0;
    return options;
}

TEST(MapAxis, SpreadsValuesByTheParametersScale) {
    const std::vector<double> gains = axis("kp", 0.1, 10.0, 3).values();
    ASSERT_EQ(gains.size(), 3U);
    EXPECT_NEAR(gains[0], 0.1, 1e-12);
    EXPECT_NEAR(gains[1], 1.0, 1e-12);
    EXPECT_EQ(gains[2], 10.0);
    const std::vector<double> from_zero = axis("kp", 0.0, 10.0, 3).values();
    EXPECT_EQ(from_zero, (std::vector<double>{0.0, 5.0, 10.0})); // 0 has no logarithm
    // A narrow range is spaced linearly, which gives round numbers on the axis.
    EXPECT_EQ(axis("kp", 10.0, 30.0, 3).values(), (std::vector<double>{10.0, 20.0, 30.0}));
    EXPECT_EQ(axis("d", 1.0, 4.0, 7).values(),
              (std::vector<double>{1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0}));
    EXPECT_EQ(axis("eta", 0.0, 1.0, 5).values().size(), 5U);
}

TEST(StabilityMap, EveryCellMatchesSingleCalls) {
    const MapAxis x = axis("kp", 2.0, 200.0, 6);
    const MapAxis y = axis("dR", 0.1, 2.0, 4);
    std::vector<double> told;
    const std::vector<MapCell> cells =
        stability_map(testing::firm(), x, y, [&told](double share) { told.push_back(share); });
    ASSERT_EQ(cells.size(), 24U);
    ASSERT_EQ(told.size(), cells.size());
    EXPECT_TRUE(std::ranges::is_sorted(told));
    EXPECT_EQ(told.back(), 1.0);
    int stable = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const MapCell &cell = cells[i];
        EXPECT_EQ(cell.x, x.values()[i % 6]);
        EXPECT_EQ(cell.y, y.values()[i / 6]);
        loops::StabilityCase there = testing::firm();
        there.tuning.K_P_V_per_rad = cell.x;
        there.net_resistance_Ohm = cell.y;
        EXPECT_EQ(cell.eigenvalue, loops::worst_member(there).eigenvalue);
        EXPECT_EQ(cell.stable, is_stable_simulated(there, of_a_map())) << cell.x << " " << cell.y;
        stable += cell.stable ? 1 : 0;
    }
    EXPECT_GT(stable, 4);
    EXPECT_LT(stable, 20);
}

TEST(StabilityMap, ReportsTheTipsRemainingSpeed) {
    loops::StabilityCase which = testing::firm();
    which.hands = {loops::no_hand()};
    which.rotor = device::RotorLoad{1e-5, 1e-5, 0.0};
    const std::vector<MapCell> cells =
        stability_map(which, axis("kp", 2.0, 300.0, 3), axis("d", 0.0, 1.0, 3), [](double) {});
    const double lever_m = device::motor_jacobian(which.device.geometry, which.q_rad).col(1).norm();
    for (const MapCell &cell : cells) {
        loops::StabilityCase there = which;
        there.tuning.K_P_V_per_rad = cell.x;
        there.delay_periods = cell.y;
        const Trial trial = simulated(there, loops::members(there).front(), of_a_map());
        EXPECT_DOUBLE_EQ(cell.remaining_m_per_s, trial.last_rate_rad_per_s * lever_m);
        EXPECT_EQ(cell.stable, trial.stable);
    }
    EXPECT_LT(cells.front().remaining_m_per_s, cells.back().remaining_m_per_s);
}

TEST(StabilityMap, OfTheWholeLinkage) {
    loops::StabilityCase which = testing::firm();
    which.freedom = loops::Freedom::three_motors;
    which.hands = {loops::no_hand(), loops::hand_of_firmness(0.5), loops::hand_of_firmness(1.0)};
    const std::vector<MapCell> cells =
        stability_map(which, axis("kp", 2.0, 300.0, 2), axis("d", 0.0, 1.0, 2), [](double) {});
    EXPECT_TRUE(cells.front().stable);
    EXPECT_LT(cells.front().eigenvalue, 1.0);
    EXPECT_FALSE(cells.back().stable);
    EXPECT_GT(cells.back().eigenvalue, 1.0);
    EXPECT_GT(cells.back().remaining_m_per_s, cells.front().remaining_m_per_s);
}

} // namespace
} // namespace springdrive::limits
