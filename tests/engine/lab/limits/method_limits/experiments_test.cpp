// Covers engine/lab/limits/method_limits: each limit of the list is crossed from both sides of its
// prediction, and where none is predicted, none is found. Predictions that have a closed form are
// compared with it.
#include "engine/lab/limits/method_limits/experiment.h"

#include "base/bisection.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"
#include "engine/lab/limits/method_limits/pressed_corner.h"
#include "engine/lab/limits/stability_limits.h"
#include "tests/support/devices.h"
#include "tests/support/stability_cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

namespace springdrive::limits {
namespace {

loops::StabilityCase with(const loops::StabilityCase &which, std::string_view name, double value) {
    return testing::with(which, testing::named(name), value);
}

/// Prediction and trial 2 % inside and 2 % outside of a limit.
void expect_crossing(const loops::StabilityCase &which, std::string_view name, double limit,
                     bool stable_below = true) {
    const TrialOptions options = TrialOptions::linear();
    const double outward = stable_below ? 0.02 : -0.02;
    const loops::StabilityCase inside = with(which, name, limit * (1.0 - outward));
    const loops::StabilityCase outside = with(which, name, limit * (1.0 + outward));
    EXPECT_TRUE(loops::is_stable(inside)) << name;
    EXPECT_TRUE(is_stable_simulated(inside, options)) << name;
    EXPECT_FALSE(loops::is_stable(outside)) << name;
    // Only the member that fails, not all before it.
    EXPECT_FALSE(simulated(outside, loops::worst_member(outside).member, options).stable) << name;
}

std::vector<StabilityLimit> limits_of(const LoopSweep &loop) {
    return predicted_limits(loop.which, *loop.parameter,
                            {loop.parameter->from, loop.parameter->to});
}

/// Trials of some seconds do not resolve less than 1 %; the linear prediction of a released hand
/// lacks the filter's lag and the motion between two samples, some 0.5 %.
void expect_crossing(const Experiment &experiment) {
    constexpr double kAside = 0.01;
    const TriedValues &tried = experiment.tried;
    const double limit = experiment.row.predicted.value();
    const double side = tried.fails_at > tried.holds_at ? kAside : -kAside;
    const double outward = tried.whole ? 1.0 : side * std::abs(limit);
    EXPECT_TRUE(experiment.holds(tried.whole ? limit : limit - outward));
    EXPECT_FALSE(experiment.holds(limit + outward));
}

void expect_as_predicted(const Experiment &experiment) {
    SCOPED_TRACE(experiment.row.method + ": " + experiment.row.fails + ", " +
                 experiment.row.setting);
    if (experiment.loop) {
        const std::vector<StabilityLimit> limits = limits_of(*experiment.loop);
        EXPECT_EQ(limits.size(), 1U);
        for (const StabilityLimit &limit : limits) {
            expect_crossing(experiment.loop->which, experiment.loop->parameter->name,
                            limit.predicted, limit.stable_below);
        }
    } else if (experiment.reading) {
        const std::optional<double> read = experiment.reading();
        ASSERT_TRUE(read && experiment.row.predicted);
        // The commutator's angle, up to 2 % of R, affects the heat of a held contact but not its
        // prediction; values counted in ticks have a tolerance of one tick.
        EXPECT_NEAR(*read, *experiment.row.predicted, 3e-3 * *experiment.row.predicted);
    } else if (experiment.row.predicted) {
        expect_crossing(experiment);
    } else {
        EXPECT_EQ(measured(experiment).front().measured, std::nullopt);
    }
}

TEST(Experiments, FailWhereTheyArePredictedTo) {
    std::set<std::string> methods;
    for (const Experiment &experiment : experiments(testing::firm())) {
        expect_as_predicted(experiment);
        methods.insert(experiment.row.method);
    }
    EXPECT_EQ(methods,
              (std::set<std::string>{
                  "resistance cancellation (6)", "resistance cancellation (6), guarded",
                  "drift compensation (10)", "inverse kinematics (18)", "transpose kinematics (23)",
                  "current-drive wall", "explicit Euler", "semi-implicit Euler", "Runge-Kutta 4",
                  "implicit midpoint", "ours (exact in energy)", "closest point (penalty)", "proxy",
                  "servo", "motor", "held contact"}));
}

/// Predictions from a device's parameters hold for another device, too. Its links are unequal, for
/// which some limits have no closed form.
TEST(Experiments, OfAnotherDeviceFailWhereTheyArePredictedTo) {
    loops::StabilityCase which;
    which.device = testing::phantom_premium_1_5();
    which.device.motor[0].resistance_Ohm *= 1.2;
    which.device.motor[1].resistance_Ohm *= 1.1;
    which.device.motor[1].inductance_H *= 1.3;
    int crossed = 0;
    for (const Experiment &experiment : experiments(which)) {
        if (experiment.row.predicted) {
            expect_as_predicted(experiment);
            ++crossed;
        }
    }
    EXPECT_GT(crossed, 20);
}

/// As the program prints it: every row once, each found within what its method allows.
TEST(Experiments, TheTableHoldsEveryRowAndWhatWasPredicted) {
    std::vector<double> shares;
    const std::vector<MethodLimit> lines =
        method_limits(testing::firm(), [&shares](double share) { shares.push_back(share); });
    EXPECT_TRUE(std::ranges::is_sorted(shares));
    EXPECT_EQ(shares.size(), experiments(testing::firm()).size());
    EXPECT_NEAR(shares.back(), 1.0, 1e-9);
    std::set<std::string> rows;
    for (const MethodLimit &line : lines) {
        SCOPED_TRACE(line.method + ": " + line.fails + ", " + line.setting);
        EXPECT_TRUE(rows.insert(line.method + line.fails + line.setting).second);
        if (line.predicted && line.measured) {
            EXPECT_NEAR(*line.measured, *line.predicted, 0.02 * std::abs(*line.predicted));
        } else {
            EXPECT_FALSE(line.predicted); // every predicted limit is found
        }
    }
    EXPECT_EQ(lines.size(), shares.size()); // one limit for each parameter of a loop
    for (const char *fails :
         {"K_P above", "K_D above", "dR below", "T above", "d above", "λ below", "α above"}) {
        EXPECT_EQ(std::ranges::count(lines, fails, &MethodLimit::fails), 1) << fails;
    }
    EXPECT_EQ(std::ranges::count(lines, "K above", &MethodLimit::fails), 2);
}

/// Each row has a tuning of its own; device, configuration and hands are those requested.
TEST(Experiments, AreForTheRequestedHandAndTheirOwnTuning) {
    loops::StabilityCase gripped = testing::firm();
    gripped.hands = {loops::hand_of_firmness(1.0)};
    gripped.tuning.K_P_V_per_rad *= 0.5;
    gripped.period_s = 2e-3;
    const std::vector<Experiment> all = experiments(gripped);
    const auto of_kp = std::ranges::find_if(all, [](const Experiment &experiment) {
        return experiment.loop && experiment.loop->parameter->name == "kp";
    });
    ASSERT_NE(of_kp, all.end());
    const std::vector<StabilityLimit> limits = limits_of(*of_kp->loop);
    ASSERT_EQ(limits.size(), 1U);
    loops::StabilityCase firm = testing::firm();
    EXPECT_FALSE(loops::is_stable(with(firm, "kp", 0.99 * limits[0].predicted)));
    firm.hands = gripped.hands;
    EXPECT_TRUE(loops::is_stable(with(firm, "kp", 0.99 * limits[0].predicted)));
    EXPECT_FALSE(loops::is_stable(with(firm, "kp", 1.01 * limits[0].predicted)));
}

TEST(Experiments, AreWrittenAsMarkdownAndAsCsv) {
    const std::vector<MethodLimit> lines{
        {"servo", "a tick later than", "ms", "1 kHz, 2 V", 51.0, 51.00001, {}}};
    std::ostringstream csv;
    write_csv(csv, method_limits_table(lines));
    EXPECT_EQ(csv.str(), "method,fails,unit,setting,predicted,measured,measured_as_it_is\n"
                         "servo,a tick later than,ms,\"1 kHz, 2 V\",51,51.00001,\n");
    std::ostringstream out;
    write_markdown(out, method_limits_document(lines));
    EXPECT_EQ(out.str(), "| method | fails | setting | predicted | measured | as it is |\n"
                         "| --- | --- | --- | ---: | ---: | ---: |\n"
                         "| servo | a tick later than (ms) | 1 kHz, 2 V | 51 | 51 | – |\n");
}

// The search for a limit.

std::optional<double> searched(const TriedValues &tried, const std::function<bool(double)> &holds) {
    return measured(Experiment{.row = {}, .tried = tried, .holds = holds}).front().measured;
}

TEST(MeasuredRow, IsEmptyWhereEverythingHolds) {
    EXPECT_EQ(searched({1.0, 1e3}, [](double) { return true; }), std::nullopt);
}

TEST(MeasuredRow, IsFoundEvenWhereTheEndHoldsAgain) {
    const auto hole = [](double x) { return x < 10.0 || x > 100.0; };
    EXPECT_NEAR(searched({1.0, 1e3}, hole).value_or(0.0), 10.0, 2e-5);
    const auto between_signs = [](double x) { return std::abs(x) > 1.0; };
    EXPECT_NEAR(searched({-6.0, 6.0}, between_signs).value_or(0.0), -1.0, 2e-6);
}

TEST(MeasuredRow, OfWholeNumbersIsTheLastThatHolds) {
    for (int last = 0; last < 9; ++last) {
        const std::optional<double> found = searched({0.0, 9.0, true}, [=](double x) {
            EXPECT_EQ(x, std::round(x));
            return x <= last;
        });
        EXPECT_EQ(found, static_cast<double>(last));
    }
}

// Closed forms of loops.

/// A count of 2π/(4 · 500 · gear) acts through K_P at once, and through K_D over a period,
/// filtered.
TEST(LoopExperiments, ACountActsThroughBothGains) {
    const control::Tuning tuning;
    const double share = -std::expm1(-tuning.lambda_rad_per_s * 1e-3);
    const double truth_mV = 1e3 * testing::phantom_1_0().rad_per_count() *
                            (tuning.K_P_V_per_rad + 1e3 * share * tuning.K_D_Vs_per_rad);
    const std::vector<Experiment> all = experiments(testing::firm());
    const auto row = std::ranges::find_if(all, [](const Experiment &experiment) {
        return experiment.row.fails == "e_W changes per count by";
    });
    ASSERT_NE(row, all.end());
    EXPECT_NEAR(row->row.predicted.value(), truth_mV, 1e-12 * truth_mV);
    EXPECT_NEAR(row->reading().value(), truth_mV, 1e-12 * truth_mV);
}

/// The cases that the rows name, built here anew: each is crossed at its row's limit.
TEST(LoopExperiments, TheFilterAndAlphaFailForTheTuningsThatTheirRowsName) {
    struct Case {
        std::string_view parameter;
        loops::StabilityCase which;
        bool stable_below;
    };
    loops::StabilityCase filtered = testing::firm();
    filtered.tuning.K_P_V_per_rad = 20.0;
    filtered.tuning.K_D_Vs_per_rad = 0.03;
    filtered.delay_periods = 1.0;
    loops::StabilityCase three = testing::firm();
    three.freedom = loops::Freedom::three_motors;
    three.tuning.K_P_V_per_rad = 20.0;
    loops::StabilityCase requested = testing::firm();
    requested.tuning.K_P_V_per_rad *= 0.5; // each row has a tuning of its own
    const std::vector<Experiment> all = experiments(requested);
    for (const Case &one : std::vector<Case>{{"lambda", filtered, false}, {"alpha", three, true}}) {
        SCOPED_TRACE(one.parameter);
        const auto row = std::ranges::find_if(all, [&one](const Experiment &experiment) {
            return experiment.loop && experiment.loop->parameter->name == one.parameter;
        });
        ASSERT_NE(row, all.end());
        const std::vector<StabilityLimit> limits = limits_of(*row->loop);
        ASSERT_EQ(limits.size(), 1U);
        EXPECT_EQ(limits[0].stable_below, one.stable_below);
        const double limit = limits[0].predicted;
        EXPECT_EQ(loops::is_stable(with(one.which, one.parameter, 0.995 * limit)),
                  one.stable_below);
        EXPECT_EQ(loops::is_stable(with(one.which, one.parameter, 1.005 * limit)),
                  !one.stable_below);
    }
}

/// Resistance cancellation (6) fails at dR = 0: with the rotor held and without gains, the current
/// decays or grows at the rate dR/L.
TEST(LoopExperiments, AnOverCancelledWindingThatIsHeld) {
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
TEST(LoopExperiments, AlphaAboveItsBound) {
    loops::StabilityCase three = testing::firm();
    three.freedom = loops::Freedom::three_motors;
    three.q_rad = {0.0, 0.1, 0.1}; // perpendicular links, so that each mode is one motor
    three.hands = {loops::no_hand()};
    loops::StabilityCase inverse = three;
    inverse.tuning.map = control::MotionMap::inverse;
    const Matrix3 J = device::motor_jacobian(three.device.geometry, three.q_rad);
    const double bound = control::alpha_bound(J, control::relative_stiffness(three.device));
    const double K_P_limit = last_that_holds({1.0, 200.0}, 1e-7, [&](double value) {
        return loops::is_stable(with(inverse, "kp", value));
    });
    // Gains just below, then just above the limit of the inverse map.
    for (const double gain : {0.9, 1.1}) {
        const double K_P = gain * K_P_limit;
        const loops::StabilityCase tuned = with(three, "kp", K_P);
        const double limit = last_that_holds({1.0, 100.0 * bound}, 1e-7, [&](double alpha) {
            return loops::is_stable(with(tuned, "alpha", alpha));
        });
        EXPECT_EQ(limit > bound, gain < 1.0) << "what (29) promises";
        // One motor after another: the mode with eigenvalue a of α JᵀJ is the loop with η = 1 − a.
        double truth = HUGE_VAL;
        for (int j = 0; j < 3; ++j) {
            loops::StabilityCase one = inverse;
            one.freedom = loops::Freedom::one_motor;
            one.tuning.K_P_V_per_rad = K_P;
            // η below 0: more than rigid.
            const double share = last_that_holds({1e-3, 100.0}, 1e-7, [&](double a) {
                loops::StabilityCase at = one;
                at.tuning.eta = 1.0 - a;
                return loops::largest_eigenvalue(at, {j, loops::no_hand()}) < 1.0;
            });
            truth = std::min(truth, share / J.col(j).squaredNorm());
        }
        EXPECT_NEAR(limit, truth, 1e-5 * truth);
    }
}

/// A mass J with damping b behind a zero-order hold and a wall K: its roots lie within the circle
/// (Jury) while K < b (1 − p)/(τ(1 − p) − pT), p = e^(−bT/J), τ = J/b; if the mass is heavy.
double sampled_wall_limit(double J, double b, double T) {
    const double p = std::exp(-b * T / J);
    const double tau = J / b;
    return b * (1.0 - p) / (tau * (1.0 - p) - p * T);
}

/// Behind an amplifier without lag; a hand that is a pure mass comes nearest to passivity's limit.
loops::StabilityCase wall_of_current_drive(double inertia_kg_m2, double damping_Nms_per_rad,
                                           double hand_mass_kg) {
    loops::StabilityCase which = testing::firm();
    which.drive = device::AmplifierKind::current_drive;
    which.device.amplifier.current_bandwidth_hz = 1e6; // lags by 0.16 µs of a 1 ms period
    which.rotor = device::RotorLoad{inertia_kg_m2, damping_Nms_per_rad, 0.0};
    which.hands = {{"mass", hand_mass_kg, 0.0, 0.0}};
    return which;
}

double squared_lever_m2(const loops::StabilityCase &which) {
    return device::motor_jacobian(which.device.geometry, which.q_rad).col(1).squaredNorm();
}

double wall_limit_N_per_m(const loops::StabilityCase &which) {
    const std::vector<StabilityLimit> limits =
        predicted_limits(which, testing::named("wall-stiffness"), {1.0, 1e6});
    EXPECT_EQ(limits.size(), 1U);
    return limits.empty() ? NAN : limits.front().predicted;
}

TEST(LoopExperiments, TheWallOfACurrentDriveFailsWhereJurySays) {
    for (const auto &[J, b] :
         {std::pair{1e-4, 1e-2}, std::pair{1e-5, 1e-3}, std::pair{1e-5, 5e-3}}) {
        const loops::StabilityCase which = wall_of_current_drive(J, b, 0.0);
        const double truth = sampled_wall_limit(J, b, which.period_s) / squared_lever_m2(which);
        const double limit = wall_limit_N_per_m(which);
        EXPECT_NEAR(limit, truth, 1e-3 * truth);
        expect_crossing(which, "wall-stiffness", limit);
    }
}

/// Colgate and Schenkel: a wall below 2b/T is passive, so that it is stable with every hand; well
/// above, a heavy enough hand makes it unstable.
TEST(LoopExperiments, ColgateAndSchenkelsWallIsStableInEveryHand) {
    for (const double b : {1e-4, 1e-3, 1e-2}) {
        loops::StabilityCase which = wall_of_current_drive(2e-6, b, 100.0);
        const double passive = 2.0 * b / which.period_s / squared_lever_m2(which);
        EXPECT_FALSE(loops::is_stable(with(which, "wall-stiffness", 1.02 * passive))) << b;
        EXPECT_TRUE(loops::is_stable(with(which, "wall-stiffness", 0.98 * passive))) << b;
        which.hands = loops::hand_family(21);
        EXPECT_TRUE(loops::is_stable(with(which, "wall-stiffness", 0.98 * passive))) << b;
    }
}

/// Delay lowers the limit: for a heavy mass, where the phases of wall and damper meet at low
/// frequency, K (T/2 + dT) < b.
TEST(LoopExperiments, ADelayedWallFailsEarlier) {
    for (const double delay : {0.0, 0.3, 0.9, 1.0, 1.5, 2.0, 3.7, 4.0}) {
        loops::StabilityCase which = wall_of_current_drive(2e-6, 1e-2, 300.0);
        which.delay_periods = delay;
        const double truth = 1e-2 / (which.period_s * (0.5 + delay)) / squared_lever_m2(which);
        EXPECT_NEAR(wall_limit_N_per_m(which), truth, 2e-3 * truth) << delay;
    }
}

/// Passivity's K (T/2 + dT + 1/ω) < b, ω the amplifier's bandwidth: for a mass without a hand it is
/// also necessary, up to terms of second order in its frequency.
TEST(LoopExperiments, RowsOfTheWallHaveTheAmplifiersLagAndTheirDelay) {
    double delay = 0.0;
    for (const Experiment &experiment : experiments(testing::firm())) {
        if (experiment.row.method == "current-drive wall") {
            const loops::StabilityCase &which = experiment.loop->which;
            const double late_s =
                1e-3 * (0.5 + delay) +
                1.0 / (2.0 * std::numbers::pi * which.device.amplifier.current_bandwidth_hz);
            const double truth = 1e-3 / late_s / squared_lever_m2(which);
            EXPECT_NEAR(wall_limit_N_per_m(which), truth, 0.05 * truth);
            delay += 1.0;
        }
    }
    EXPECT_EQ(delay, 2.0);
}

TEST(LateTicks, WithoutLatenessAreTwoTicksOfThePlainLoop) {
    loops::StabilityCase which = testing::firm();
    which.freedom = loops::Freedom::three_motors;
    which.hands = {loops::hand_of_firmness(0.5)};
    for (const double K_P : {1.0, 6.0, 25.0, 60.0}) {
        which.tuning.K_P_V_per_rad = K_P;
        const loops::LoopMember member = loops::members(which).front();
        const double once = loops::largest_eigenvalue(which, member);
        // Double roots are accurate to half of the digits.
        EXPECT_NEAR(late_ticks_eigenvalue(which, member, 0), once * once, 1e-7) << K_P;
    }
}

} // namespace
} // namespace springdrive::limits
