// Covers engine/lab/charts/friction_integrator_chart.cpp, and integrator_trial.cpp
// where there is friction.
#include "engine/lab/charts/friction_integrator_chart.h"

#include "engine/lab/charts/integrator_trial.h"
#include "tests/engine/lab/charts/quick_setting.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <set>
#include <string>

namespace springdrive::charts {
namespace {

const IntegratorTrial &trial() {
    static const IntegratorTrial made(press_of(testing::quick_setting(), rig::sticking_press()));
    return made;
}

double error_N(const NewPlant &new_plant) {
    return force_error_N(run_press(trial().press(), new_plant), trial().reference());
}

/// How far the motors turn while the hand holds, in the last quarter before the release [rad].
double turned_in_hold_rad(const NewPlant &new_plant) {
    const rig::Scenario &press = trial().press();
    const auto period_at = [&](double time_s) {
        return static_cast<int>(std::lround(time_s / press.simulation.servo_period_s));
    };
    const int from = period_at(0.75 * rig::sticking_press().release_s);
    const int until = period_at(rig::sticking_press().release_s);
    const std::unique_ptr<PressedPlant> plant = new_plant();
    rig::LawRig loop = press_loop(press, *plant);
    Vector3 minimum = Vector3::Zero();
    Vector3 maximum = Vector3::Zero();
    for (int period = 0; period < until; ++period) {
        const Vector3 theta_rad = plant->theta_rad();
        minimum = period <= from ? theta_rad : Vector3(minimum.cwiseMin(theta_rad));
        maximum = period <= from ? theta_rad : Vector3(maximum.cwiseMax(theta_rad));
        loop.tick();
    }
    return (maximum - minimum).maxCoeff();
}

TEST(StickingPress, PressesHoldsAndReleases) {
    const PressRecord &reference = trial().reference();
    const rig::Scenario &press = trial().press();
    EXPECT_GT(reference.max_force_N(), 2.0);
    EXPECT_LT(reference.max_force_N(), press.device.limits.tip_force_N);
    const auto released = static_cast<std::size_t>(
        std::lround(rig::sticking_press().release_s / press.simulation.servo_period_s));
    EXPECT_GT(reference.force_N[released - 1].dot(press.normal), 2.0);
    EXPECT_LT(reference.force_N.back().norm(), 0.5); // the rest is held by friction
}

TEST(StickingPress, TrueFrictionHoldsTheJointsExactly) {
    EXPECT_EQ(turned_in_hold_rad(trial().reference_plant(CvodeMethod::adams, 1e-12)), 0.0);
    EXPECT_EQ(turned_in_hold_rad(trial().plant(Integrator::simulator, 10)), 0.0);
    EXPECT_EQ(turned_in_hold_rad(trial().plant(Integrator::simulator, 1)), 0.0);
    // Friction by the sign chatters, smoothed friction creeps.
    EXPECT_GT(turned_in_hold_rad(trial().plant(Integrator::runge_kutta, 10)), 0.0);
    EXPECT_GT(turned_in_hold_rad(trial().cvode_plant(CvodeMethod::bdf, 1e-6, 1e-4)), 0.0);
}

TEST(FrictionReference, AgreesWithItselfByAnotherMethodAndByTolerance) {
    // Of forces of some newtons, after a few hundred steps.
    EXPECT_LT(error_N(trial().reference_plant(CvodeMethod::bdf, 1e-11)), 1e-8);
    EXPECT_LT(error_N(trial().reference_plant(CvodeMethod::adams, 1e-11)), 1e-9);
}

TEST(FrictionReference, IsTheLimitOfSmoothedFriction) {
    // Smoothed friction has no sticking: its error is proportional to its width.
    const double wide_N = error_N(trial().cvode_plant(CvodeMethod::bdf, 1e-8, 1e-5));
    const double narrow_N = error_N(trial().cvode_plant(CvodeMethod::bdf, 1e-8, 1e-6));
    EXPECT_NEAR(wide_N / narrow_N, 10.0, 0.5);
    EXPECT_LT(narrow_N, 1e-4);
}

TEST(FrictionIntegrators, ConvergeWithShorterSteps) {
    for (const NamedIntegrator &named : kIntegrators) {
        const bool is_smoothed = named.integrator == Integrator::implicit_midpoint;
        const auto error_of = [&](int sub_steps) {
            const double step_s = trial().press().simulation.servo_period_s / sub_steps;
            return error_N(
                trial().plant(named.integrator, sub_steps,
                              is_smoothed ? trial().friction_width_rad_per_s(step_s) : 0.0));
        };
        // First order for the explicit and smoothed methods, whatever their order without friction;
        // the simulated device is better.
        const double order = std::log2(error_of(8) / error_of(64)) / std::log2(8.0);
        if (named.integrator == Integrator::simulator) {
            EXPECT_GT(order, 1.2);
        } else {
            EXPECT_NEAR(order, 1.0, 0.25) << named.name;
        }
    }
}

TEST(FrictionIntegratorChart, HasALineForEachMethodAndCrossesTheRest) {
    double done = 0.0;
    const SpeedAccuracyChart chart =
        friction_integrator_chart(testing::quick_setting(), [&](double share) { done = share; });
    EXPECT_DOUBLE_EQ(done, 1.0);
    std::set<std::string> methods;
    for (const ChartPoint &point : chart.points) {
        methods.insert(point.method);
        EXPECT_FALSE(point.setting.empty());
        EXPECT_EQ(point.stable, std::isfinite(point.error));
        if (point.stable) {
            EXPECT_GT(point.cost.min_ns, 0.0);
            EXPECT_LE(point.cost.min_ns, point.cost.max_ns);
        }
    }
    EXPECT_EQ(methods.size(), kIntegrators.size() + 2); // two of CVODE
    EXPECT_FALSE(chart.points.front().stable);          // explicit Euler at 1 ms
}

} // namespace
} // namespace springdrive::charts
