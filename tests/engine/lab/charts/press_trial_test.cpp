// Covers engine/lab/charts/press_trial.cpp, and plant_solvers.cpp on its plants.
#include "engine/lab/charts/press_trial.h"

#include "tests/engine/lab/charts/quick_setting.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <numbers>

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

const IntegratorTrial &sticking_trial() {
    static const IntegratorTrial trial(press_of(testing::quick_setting(), rig::sticking_press()));
    return trial;
}

TEST(Press, PressesHardAndStaysInTheSurfaceUntilItReleases) {
    for (const IntegratorTrial *trial : {&pen_trial(), &vice_trial(), &sticking_trial()}) {
        const PressRecord &reference = trial->reference();
        const rig::Scenario &press = trial->press();
        ASSERT_EQ(static_cast<int>(reference.force_N.size()), periods_of(press));
        EXPECT_GT(reference.max_force_N(), 2.0);
        EXPECT_LT(reference.max_force_N(), press.device.limits.tip_force_N);
        const auto released = static_cast<std::size_t>(
            trial == &sticking_trial()
                ? std::lround(rig::sticking_press().release_s / press.simulation.servo_period_s)
                : periods_of(press));
        for (std::size_t k = 0; k < released; ++k) {
            EXPECT_GT(reference.force_N[k].dot(press.normal), 0.0); // the plate pushes out
        }
        if (trial == &sticking_trial()) {
            EXPECT_GT(reference.force_N[released - 1].dot(press.normal), 2.0);
            EXPECT_LT(reference.force_N.back().norm(), 0.5); // the rest is held by friction
        }
    }
}

TEST(Press, TheHandsTargetHasItsCornersAtTheSamples) {
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
            const double order =
                std::log2(trial->error_N(trial->plant(named.integrator, sub_steps)) /
                          trial->error_N(trial->plant(named.integrator, 2 * sub_steps)));
            EXPECT_NEAR(order, named.order, 0.1) << named.name;
        }
    }
}

TEST(CvodeOfPlant, AgreesWithItselfByAnotherMethodAndByTolerance) {
    for (const IntegratorTrial *trial : {&pen_trial(), &vice_trial(), &sticking_trial()}) {
        const auto error_N = [&](CvodeMethod method, double tolerance) {
            return trial->error_N(trial->reference_plant(method, tolerance));
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
    const auto error_N = [&trial](Integrator integrator, int sub_steps) {
        return trial.error_N(trial.plant(integrator, sub_steps));
    };
    EXPECT_FALSE(std::isfinite(error_N(Integrator::explicit_euler, 4)));
    EXPECT_TRUE(std::isfinite(error_N(Integrator::explicit_euler, 5)));
    // And 2.785 L/R is 304 µs.
    EXPECT_FALSE(std::isfinite(error_N(Integrator::runge_kutta, 3)));
    EXPECT_TRUE(std::isfinite(error_N(Integrator::runge_kutta, 4)));
    // The others do not diverge at any step.
    EXPECT_LT(error_N(Integrator::simulator, 1), trial.reference().max_force_N());
    EXPECT_LT(error_N(Integrator::implicit_midpoint, 1), trial.reference().max_force_N());
}

/// How far the motors turn while the hand holds, in the last quarter before the release [rad].
double turned_in_hold_rad(const NewPlant &new_plant) {
    const rig::Scenario &press = sticking_trial().press();
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

TEST(FrictionIntegrators, TrueFrictionHoldsTheJointsExactly) {
    EXPECT_EQ(turned_in_hold_rad(sticking_trial().reference_plant(CvodeMethod::adams, 1e-12)), 0.0);
    EXPECT_EQ(turned_in_hold_rad(sticking_trial().plant(Integrator::simulator, 10)), 0.0);
    EXPECT_EQ(turned_in_hold_rad(sticking_trial().plant(Integrator::simulator, 1)), 0.0);
    // Friction by the sign chatters, smoothed friction creeps.
    EXPECT_GT(turned_in_hold_rad(sticking_trial().plant(Integrator::runge_kutta, 10)), 0.0);
    EXPECT_GT(turned_in_hold_rad(sticking_trial().cvode_plant(CvodeMethod::bdf, 1e-6, 1e-4)), 0.0);
}

TEST(FrictionReference, IsTheLimitOfSmoothedFriction) {
    const IntegratorTrial &trial = sticking_trial();
    // Smoothed friction has no sticking: its error is proportional to its width.
    const double wide_N = trial.error_N(trial.cvode_plant(CvodeMethod::bdf, 1e-8, 1e-5));
    const double narrow_N = trial.error_N(trial.cvode_plant(CvodeMethod::bdf, 1e-8, 1e-6));
    EXPECT_NEAR(wide_N / narrow_N, 10.0, 0.5);
    EXPECT_LT(narrow_N, 1e-4);
}

TEST(FrictionIntegrators, ConvergeWithShorterSteps) {
    const IntegratorTrial &trial = sticking_trial();
    for (const NamedIntegrator &named : kIntegrators) {
        const bool is_smoothed = named.integrator == Integrator::implicit_midpoint;
        const auto error_of = [&](int sub_steps) {
            const double step_s = trial.press().simulation.servo_period_s / sub_steps;
            return trial.error_N(
                trial.plant(named.integrator, sub_steps,
                            is_smoothed ? trial.friction_width_rad_per_s(step_s) : 0.0));
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

TEST(ModelPlant, ReadsItsEncodersInWholeCounts) {
    const rig::Scenario press = press_of(testing::quick_setting(), rig::planar_press());
    const double counts_per_rad = press.device.encoder_counts_per_turn / (2.0 * std::numbers::pi);
    for (const simulated::PlantModel &model : simulated::kPlantModels) {
        const std::unique_ptr<PressedPlant> plant = model_plant(press, model, false, 10)();
        for (int period = 0; period < periods_of(press); ++period) {
            plant->advance({device::DeviceCommand::braking(), Vector3::Zero()});
            for (const double theta_rad : plant->theta_rad()) {
                const double counts = theta_rad * counts_per_rad;
                ASSERT_NEAR(counts, std::round(counts), 1e-9);
            }
        }
    }
}

} // namespace
} // namespace springdrive::charts
