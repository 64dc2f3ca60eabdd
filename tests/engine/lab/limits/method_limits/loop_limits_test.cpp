// Covers engine/lab/limits/method_limits/loop_limits.cpp: each limit of a loop (docs/design.md,
// "Where methods fail"), crossed from both sides, by prediction and by trials.
#include "engine/lab/limits/method_limits/loop_limits.h"

#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"
#include "engine/lab/limits/stability_limits.h"
#include "tests/support/devices.h"
#include "tests/support/stability_cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <string_view>

namespace springdrive::limits {
namespace {

loops::StabilityCase with(loops::StabilityCase which, std::string_view name, double value) {
    loops::stability_parameter_named(name)->set(which, value);
    return which;
}

double last_that_holds(double stable, double unstable, const std::function<bool(double)> &holds) {
    while (std::abs(unstable - stable) > 1e-7 * std::abs(stable)) {
        const double middle = 0.5 * (stable + unstable);
        (holds(middle) ? stable : unstable) = middle;
    }
    return stable;
}

/// Prediction and trial 2 % inside and 2 % outside of a limit.
void expect_crossing(const loops::StabilityCase &which, std::string_view name, double limit,
                     bool stable_below = true, double longest_s = 3.0) {
    TrialOptions options = TrialOptions::linear();
    options.longest_s = longest_s;
    const double outward = stable_below ? 0.02 : -0.02;
    const loops::StabilityCase inside = with(which, name, limit * (1.0 - outward));
    const loops::StabilityCase outside = with(which, name, limit * (1.0 + outward));
    EXPECT_TRUE(loops::is_stable(inside)) << name;
    EXPECT_TRUE(is_stable_simulated(inside, options)) << name;
    EXPECT_FALSE(loops::is_stable(outside)) << name;
    // Only the member that fails, not all before it.
    EXPECT_FALSE(simulated(outside, loops::worst_member(outside).member, options).stable) << name;
}

StabilityLimit only_limit(const loops::StabilityCase &which, std::string_view name, double from,
                          double to) {
    const std::vector<StabilityLimit> limits =
        predicted_limits(which, *loops::stability_parameter_named(name), {from, to});
    EXPECT_EQ(limits.size(), 1U) << name;
    return limits.empty() ? StabilityLimit{} : limits.front();
}

TEST(LoopLines, DriftCompensationGains) {
    for (const auto &[name, to] : {std::pair{"kp", 200.0}, std::pair{"kd", 1.0}}) {
        const StabilityLimit limit = only_limit(testing::firm(), name, 1e-3, to);
        EXPECT_TRUE(limit.stable_below);
        expect_crossing(testing::firm(), name, limit.predicted);
    }
}

TEST(LoopLines, AServoThatIsTooSlow) {
    const StabilityLimit limit = only_limit(testing::firm(), "T", 1e-4, 0.02);
    EXPECT_TRUE(limit.stable_below);
    expect_crossing(testing::firm(), "T", limit.predicted);
}

TEST(LoopLines, AFilterThatIsTooSlow) {
    // Where K_D is what keeps the loop stable, its lag matters.
    loops::StabilityCase which = testing::firm();
    which.tuning.K_P_V_per_rad = 25.0;
    const StabilityLimit limit = only_limit(which, "lambda", 20.0, 1000.0);
    EXPECT_FALSE(limit.stable_below);
    expect_crossing(which, "lambda", limit.predicted, false);
}

TEST(LoopLines, ADelayThatIsTooLong) {
    const StabilityLimit limit = only_limit(testing::firm(), "d", 0.0, 8.0);
    EXPECT_TRUE(limit.stable_below);
    expect_crossing(testing::firm(), "d", limit.predicted);
    // At this delay K_P is at its limit, too.
    loops::StabilityCase which = testing::firm();
    which.delay_periods = limit.predicted;
    const double K_P = which.tuning.K_P_V_per_rad;
    const double K_P_limit = only_limit(which, "kp", 0.01, 200.0).predicted;
    EXPECT_NEAR(K_P_limit, K_P, 1e-5 * K_P); // both by bisection to 1e-6
    for (const double delay : {limit.predicted, std::ceil(limit.predicted)}) {
        which.delay_periods = delay;
        expect_crossing(which, "kp", only_limit(which, "kp", 0.01, 200.0).predicted);
    }
}

TEST(LoopLines, AResidualThatIsTooSmallForTheGains) {
    const StabilityLimit limit = only_limit(testing::firm(), "dR", 0.02, 2.18);
    EXPECT_FALSE(limit.stable_below);
    expect_crossing(testing::firm(), "dR", limit.predicted, false);
}

/// Resistance cancellation (6) fails at dR = 0: with the rotor held and without gains, the current
/// decays or grows at the rate dR/L.
TEST(LoopLines, AnOverCancelledWindingThatIsHeld) {
    loops::StabilityCase which = testing::firm();
    which.rotor = device::RotorLoad{1e-3, 6.3, 1e4}; // a vice
    which.hands = {loops::no_hand()};
    which.tuning.K_P_V_per_rad = which.tuning.K_D_Vs_per_rad = 0.0;
    const loops::LoopMember member = loops::members(which).front();
    const double L = which.device.motor[1].inductance_H;
    for (const double dR : {0.1, 0.002, -0.002, -0.1}) { // within 0.1 % of 2.18 Ω, and farther
        which.net_resistance_Ohm = dR;
        EXPECT_EQ(loops::is_stable(which), dR > 0.0) << dR;
        const Trial trial = simulated(which, member, TrialOptions::linear());
        EXPECT_EQ(trial.stable, dR > 0.0) << dR;
        if (std::abs(dR) < 0.01) { // otherwise it ends before the initial transient has decayed
            EXPECT_NEAR(trial.growth_per_s, -dR / L, 0.01 * std::abs(dR) / L) << dR;
        }
    }
}

/// (29) and its consequence: at the bound the largest mode is the inverse map's, and α may exceed
/// the bound only by the margin of one motor's gains.
TEST(LoopLines, AlphaAboveItsBound) {
    loops::StabilityCase three = testing::firm();
    three.freedom = loops::Freedom::three_motors;
    three.q_rad = {0.0, 0.1, 0.1}; // perpendicular links, so that each mode is one motor
    three.hands = {loops::no_hand()};
    loops::StabilityCase inverse = three;
    inverse.tuning.map = control::MotionMap::inverse;
    const Matrix3 J = device::motor_jacobian(three.device.geometry, three.q_rad);
    const Vector3 W = control::relative_stiffness(three.device);
    const double bound = control::alpha_bound(J, W);
    // Gains just below, then just above the limit of the inverse map.
    for (const double gain : {0.9, 1.1}) {
        double K_P = last_that_holds(
            1.0, 200.0, [&](double value) { return loops::is_stable(with(inverse, "kp", value)); });
        K_P *= gain;
        const loops::StabilityCase tuned = with(three, "kp", K_P);
        const double limit = last_that_holds(1.0, 100.0 * bound, [&](double alpha) {
            return loops::is_stable(with(tuned, "alpha", alpha));
        });
        if (gain < 1.0) {
            EXPECT_GT(limit, bound) << "what (29) promises";
        }
        expect_crossing(tuned, "alpha", limit, true, 1.0);
        // One motor after another: the mode with eigenvalue a of α JᵀJ is the loop with η = 1 − a.
        double truth = HUGE_VAL;
        for (int j = 0; j < 3; ++j) {
            loops::StabilityCase one = inverse;
            one.freedom = loops::Freedom::one_motor;
            one.tuning.K_P_V_per_rad = K_P;
            // η below 0: more than rigid.
            const double share = last_that_holds(1e-3, 100.0, [&](double a) {
                loops::StabilityCase at = one;
                at.tuning.eta = 1.0 - a;
                return loops::largest_eigenvalue(at, {j, loops::no_hand()}) < 1.0;
            });
            truth = std::min(truth, share / J.col(j).squaredNorm());
        }
        EXPECT_NEAR(limit, truth, 1e-5 * truth);
    }
}

/// The purpose of (29): with K_P within the limit of the inverse map, a motor's own limit of α is
/// the bound times its margin.
TEST(LoopLines, AlphaOfOneMotorHasItsGainsMargin) {
    loops::StabilityCase which = testing::firm();
    which.hands = {loops::no_hand()};
    which.tuning.K_D_Vs_per_rad = 0.0;
    const Matrix3 J = device::motor_jacobian(which.device.geometry, which.q_rad);
    const double bound = control::alpha_bound(J, control::relative_stiffness(which.device));
    const double limit = last_that_holds(
        1.0, 1e6, [&](double alpha) { return loops::is_stable(with(which, "alpha", alpha)); });
    EXPECT_GT(limit, bound);
    expect_crossing(which, "alpha", limit);
}

/// A mass J with damping b behind a zero-order hold and a wall K: its roots lie within the circle
/// (Jury) while K < b (1 − p)/(τ(1 − p) − pT), p = e^(−bT/J), τ = J/b; if the mass is heavy.
double sampled_wall_limit(double J, double b, double T) {
    const double p = std::exp(-b * T / J);
    const double tau = J / b;
    return b * (1.0 - p) / (tau * (1.0 - p) - p * T);
}

loops::StabilityCase wall_of_current_drive(double inertia_kg_m2, double damping_Nms_per_rad) {
    loops::StabilityCase which = testing::firm();
    which.drive = device::AmplifierKind::current_drive;
    which.device.amplifier.current_bandwidth_hz = 1e6; // ideal
    which.rotor = device::RotorLoad{inertia_kg_m2, damping_Nms_per_rad, 0.0};
    which.hands = {loops::no_hand()};
    return which;
}

double squared_lever_m2(const loops::StabilityCase &which) {
    return device::motor_jacobian(which.device.geometry, which.q_rad).col(1).squaredNorm();
}

TEST(LoopLines, TheWallOfACurrentDrive) {
    for (const auto &[J, b] :
         {std::pair{1e-4, 1e-2}, std::pair{1e-5, 1e-3}, std::pair{1e-5, 5e-3}}) {
        const loops::StabilityCase which = wall_of_current_drive(J, b);
        const double truth = sampled_wall_limit(J, b, which.period_s) / squared_lever_m2(which);
        const StabilityLimit limit = only_limit(which, "wall-stiffness", 1.0, 1e6);
        // 1 MHz lags by 0.16 µs of a 1 ms period.
        EXPECT_NEAR(limit.predicted, truth, 1e-3 * truth);
        expect_crossing(which, "wall-stiffness", limit.predicted);
    }
}

/// Colgate and Schenkel: a wall below 2b/T is passive, so that it is stable with every hand; well
/// above, a heavy enough hand makes it unstable.
TEST(LoopLines, ColgateAndSchenkelsWallIsStableInEveryHand) {
    for (const double b : {1e-4, 1e-3, 1e-2}) {
        loops::StabilityCase which = wall_of_current_drive(2e-6, b);
        const double passive = 2.0 * b / which.period_s / squared_lever_m2(which);
        which.hands = loops::hand_family(21);
        which.wall.stiffness_N_per_m = 0.98 * passive;
        EXPECT_TRUE(loops::is_stable(which)) << b;
        // A hand that is a pure mass comes nearest to the limit.
        which.hands = {{"mass", 100.0, 0.0, 0.0}};
        which.wall.stiffness_N_per_m = 1.02 * passive;
        EXPECT_FALSE(loops::is_stable(which)) << b;
        which.wall.stiffness_N_per_m = 0.98 * passive;
        EXPECT_TRUE(loops::is_stable(which)) << b;
    }
}

/// Delay lowers the limit: for a heavy mass, where the phases of wall and damper meet at low
/// frequency, K (T/2 + dT) < b.
TEST(LoopLines, ADelayedWallFailsEarlier) {
    for (const double delay : {0.0, 0.3, 0.9, 1.0, 1.5, 2.0, 3.7, 4.0}) {
        loops::StabilityCase which = wall_of_current_drive(2e-6, 1e-2);
        which.hands = {{"mass", 300.0, 0.0, 0.0}};
        which.delay_periods = delay;
        const double truth = 1e-2 / (which.period_s * (0.5 + delay)) / squared_lever_m2(which);
        const StabilityLimit limit = only_limit(which, "wall-stiffness", 1.0, 1e6);
        EXPECT_NEAR(limit.predicted, truth, 2e-3 * truth) << delay;
    }
}

/// The values of a row are where prediction and trial change, at the tuning that the row names.
void expect_row(const MethodLimit &line, const std::string &fails,
                const loops::StabilityCase &which, std::string_view name,
                bool stable_below = true) {
    SCOPED_TRACE(fails);
    EXPECT_EQ(line.fails, fails);
    ASSERT_TRUE(line.predicted && line.measured);
    expect_crossing(which, name, *line.predicted, stable_below);
    EXPECT_NEAR(*line.measured, *line.predicted, 0.02 * *line.predicted);
}

TEST(LoopLines, RowsOfDriftCompensationAreWhereVerdictsTurn) {
    int steps = 0;
    loops::StabilityCase asked = testing::firm();
    asked.tuning.K_P_V_per_rad *= 0.5; // each row has a tuning of its own
    const std::vector<MethodLimit> lines = drift_limits(asked, [&steps] { ++steps; });
    EXPECT_EQ(steps, kDriftSteps);
    ASSERT_EQ(lines.size(), 7U);
    expect_row(lines[0], "K_P above", testing::firm(), "kp");
    expect_row(lines[1], "K_D above", testing::firm(), "kd");
    expect_row(lines[2], "dR below", testing::firm(), "dR", false);
    expect_row(lines[3], "T above", testing::firm(), "T");
    expect_row(lines[4], "d above", testing::firm(), "d");
    loops::StabilityCase filtered = testing::firm();
    filtered.tuning.K_P_V_per_rad = 20.0;
    filtered.tuning.K_D_Vs_per_rad = 0.03;
    filtered.delay_periods = 1.0;
    expect_row(lines[5], "λ below", filtered, "lambda", false);
    // A count of 2π/(4 · 500 · gear) acts through K_P at once, and through K_D over a period,
    // filtered.
    const control::Tuning tuning;
    const double count_rad = asked.device.rad_per_count();
    const double share = -std::expm1(-tuning.lambda_rad_per_s * 1e-3);
    const double truth_mV =
        1e3 * count_rad * (tuning.K_P_V_per_rad + 1e3 * share * tuning.K_D_Vs_per_rad);
    EXPECT_NEAR(lines[6].predicted.value(), truth_mV, 1e-12 * truth_mV);
    EXPECT_NEAR(lines[6].measured.value(), truth_mV, 1e-12 * truth_mV);
}

TEST(LoopLines, RowOfAlphaIsWhereVerdictsTurn) {
    loops::StabilityCase three = testing::firm();
    three.freedom = loops::Freedom::three_motors;
    three.tuning.K_P_V_per_rad = 20.0;
    const std::vector<MethodLimit> lines = alpha_limits(testing::firm());
    ASSERT_EQ(lines.size(), 1U);
    expect_row(lines[0], "α above", three, "alpha");
}

TEST(LoopLines, RowsOfTheWallAreWhereVerdictsTurnAndFallWithTheDelay) {
    const std::vector<MethodLimit> lines = wall_limits(testing::firm());
    ASSERT_EQ(lines.size(), 2U);
    loops::StabilityCase wall = testing::firm();
    wall.drive = device::AmplifierKind::current_drive;
    wall.hands = {loops::no_hand()};
    wall.rotor = device::RotorLoad{1e-4, 1e-3, 0.0};
    wall.wall = {1.0, 0.0};
    for (const MethodLimit &line : lines) {
        expect_row(line, "K above", wall, "wall-stiffness");
        // Passivity's K (T/2 + dT + 1/ω) < b, ω the amplifier's bandwidth: for a mass without a
        // hand it is also necessary, up to terms of second order in its frequency.
        const double late_s =
            1e-3 * (0.5 + wall.delay_periods) +
            1.0 / (2.0 * std::numbers::pi * wall.device.amplifier.current_bandwidth_hz);
        const double truth = 1e-3 / late_s / squared_lever_m2(wall);
        EXPECT_NEAR(*line.predicted, truth, 0.05 * truth);
        wall.delay_periods += 1.0;
    }
}

} // namespace
} // namespace springdrive::limits
