// Covers engine/lab/charts/integrator_chart.cpp, integrator_trial.cpp,
// cvode_solver.cpp and contact_press.cpp.
#include "engine/lab/charts/integrator_chart.h"

#include "engine/lab/charts/integrator_trial.h"
#include "tests/engine/lab/charts/quick_setting.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>

namespace springdrive::charts {
namespace {

const IntegratorTrial &pen_trial() {
    static const IntegratorTrial trial(press_of(testing::quick_setting(), rig::pen_press()));
    return trial;
}

const IntegratorTrial &vice_trial() {
    static const IntegratorTrial trial(press_of(testing::quick_setting(), rig::vice_press()));
    return trial;
}

TEST(ContactPress, PressesHardAndStaysInTheSurface) {
    for (const IntegratorTrial *trial : {&pen_trial(), &vice_trial()}) {
        const PressRecord &reference = trial->reference();
        ASSERT_EQ(static_cast<int>(reference.force_N.size()), periods_of(trial->press()));
        for (const Vector3 &force_N : reference.force_N) {
            EXPECT_GT(force_N.dot(trial->press().normal), 0.0); // the plate pushes out
        }
        EXPECT_GT(reference.max_force_N(), 2.0);
        EXPECT_LT(reference.max_force_N(), trial->press().device.limits.tip_force_N);
    }
}

TEST(ContactPress, TheHandsTargetHasItsCornersAtTheSamples) {
    const rig::Scenario press = press_of(testing::quick_setting(), rig::pen_press());
    simulated::HandPath path = *press.simulation.path;
    EXPECT_EQ(path.at(0.0).position_m, press.start_m);
    const Vector3 end_m = path.at(periods_of(press) * press.simulation.servo_period_s).position_m;
    EXPECT_LT((end_m - (press.start_m - rig::pen_press().press_m * press.normal)).norm(), 1e-15);
    for (std::size_t k = 0; k < path.points().size(); ++k) {
        EXPECT_EQ(path.points()[k].time_s,
                  static_cast<double>(k) * press.simulation.servo_period_s);
    }
}

TEST(ForceError, IsARootMeanSquareOrInfinite) {
    PressRecord reference;
    reference.force_N = {Vector3(1.0, 0.0, 0.0), Vector3(0.0, 2.0, 0.0)};
    PressRecord record = reference;
    EXPECT_EQ(force_error_N(record, reference), 0.0);
    record.force_N[1] += Vector3(0.0, 3.0, 4.0);
    EXPECT_DOUBLE_EQ(force_error_N(record, reference), 5.0 / std::sqrt(2.0));
    record.force_N[1] = Vector3(0.0, 19.9, 0.0); // ten times the largest is 20 N
    EXPECT_LT(force_error_N(record, reference), 20.0);
    record.force_N[1] = Vector3(0.0, 20.1, 0.0);
    EXPECT_EQ(force_error_N(record, reference), std::numeric_limits<double>::infinity());
    record.force_N[1] = Vector3(0.0, std::nan(""), 0.0);
    EXPECT_EQ(force_error_N(record, reference), std::numeric_limits<double>::infinity());
}

TEST(Integrators, ConvergeOnTheContactTransientAtTheirOrders) {
    for (const IntegratorTrial *trial : {&pen_trial(), &vice_trial()}) {
        for (const NamedIntegrator &named : kIntegrators) {
            // Where steps are short enough for the next order to be negligible.
            const bool slow = named.order < 2.0;
            const int sub_steps = slow ? 512 : 32;
            const double order = std::log2(trial->error_N(named.integrator, sub_steps) /
                                           trial->error_N(named.integrator, 2 * sub_steps));
            EXPECT_NEAR(order, named.order, 0.1) << named.name;
        }
    }
}

TEST(CvodeOfPlant, AgreesWithItselfByAnotherMethodAndByTolerance) {
    for (const IntegratorTrial *trial : {&pen_trial(), &vice_trial()}) {
        const auto error_N = [&](CvodeMethod method, double tolerance) {
            return force_error_N(run_press(trial->press(), trial->cvode_plant(method, tolerance)),
                                 trial->reference());
        };
        // Of forces of some newtons, after a few hundred steps.
        EXPECT_LT(error_N(CvodeMethod::bdf, 1e-11), 1e-8);
        EXPECT_LT(error_N(CvodeMethod::adams, 1e-11), 1e-9);
        EXPECT_GT(error_N(CvodeMethod::adams, 1e-4), error_N(CvodeMethod::adams, 1e-8));
    }
}

TEST(Integrators, DivergeWhereTheirStepIsTooLong) {
    // With nothing cancelled 2 L/R is 218 µs: between 4 and 5 steps a period.
    ChartSetting braked = testing::quick_setting();
    braked.tuning.dR_Ohm = braked.device.motor[0].resistance_Ohm;
    const IntegratorTrial trial(press_of(braked, rig::pen_press()));
    EXPECT_FALSE(std::isfinite(trial.error_N(Integrator::explicit_euler, 4)));
    EXPECT_TRUE(std::isfinite(trial.error_N(Integrator::explicit_euler, 5)));
    // And 2.785 L/R is 304 µs.
    EXPECT_FALSE(std::isfinite(trial.error_N(Integrator::runge_kutta, 3)));
    EXPECT_TRUE(std::isfinite(trial.error_N(Integrator::runge_kutta, 4)));
    // The others do not diverge at any step.
    EXPECT_LT(trial.error_N(Integrator::simulator, 1), trial.reference().max_force_N());
    EXPECT_LT(trial.error_N(Integrator::implicit_midpoint, 1), trial.reference().max_force_N());
}

TEST(IntegratorChart, HasALineForEachMethodAndCrossesTheRest) {
    double done = 0.0;
    const SpeedAccuracyChart chart =
        stiff_integrator_chart(testing::quick_setting(), [&](double share) { done = share; });
    EXPECT_EQ(done, 1.0);
    std::set<std::string> methods;
    int crosses = 0;
    for (const ChartPoint &point : chart.points) {
        methods.insert(point.method);
        EXPECT_FALSE(point.setting.empty());
        EXPECT_GT(point.cost.min_ns, 0.0);
        EXPECT_LE(point.cost.min_ns, point.cost.median_ns);
        EXPECT_LE(point.cost.median_ns, point.cost.max_ns);
        EXPECT_EQ(point.stable, std::isfinite(point.error));
        crosses += point.stable ? 0 : 1;
    }
    EXPECT_EQ(methods.size(), kIntegrators.size() + 2); // two of CVODE
    EXPECT_GT(crosses, 0);                              // a vice is too stiff for Euler at 1 ms
    EXPECT_FALSE(chart.points.front().stable);
}

} // namespace
} // namespace springdrive::charts
