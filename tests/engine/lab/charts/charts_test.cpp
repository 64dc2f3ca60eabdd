// Covers engine/lab/charts/charts.h: each chart as a whole, and press_charts.cpp with its press and
// its solvers, plant_solvers.cpp.
#include "base/input_error.h"
#include "device/simulated/simulation_options.h"
#include "engine/lab/charts/charts.h"
#include "engine/lab/charts/plant_solvers.h"
#include "engine/lab/charts/press_trial.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::charts {
namespace {

/// The PHANTOM 1.0, each cost measured once: for tests of errors.
ChartSetting quick_setting() {
    ChartSetting setting;
    setting.device = testing::phantom_1_0();
    setting.repeats = 1;
    return setting;
}

/// The charts that are tried, each made once, with how often its progress was reported.
const SpeedAccuracyChart &chart(const std::string &name) {
    static std::map<std::string, SpeedAccuracyChart> made;
    if (!made.contains(name)) {
        const auto *maker = std::ranges::find(kCharts, name, &ChartMaker::name);
        double last_share = 0.0;
        made[name] = maker->make(quick_setting(), [&last_share](double share) {
            EXPECT_GT(share, last_share);
            last_share = share;
        });
        EXPECT_NEAR(last_share, 1.0, 1e-12) << name;
    }
    return made[name];
}

/// The points of each line, in their order.
std::map<std::string, std::vector<ChartPoint>> lines(const std::string &name) {
    std::map<std::string, std::vector<ChartPoint>> sorted;
    for (const ChartPoint &point : chart(name).points) {
        sorted[point.method].push_back(point);
    }
    return sorted;
}

TEST(Charts, HaveTheirLinesWithCostsAndCrosses) {
    const std::size_t models = simulated::kPlantModels.size();
    struct Case {
        const char *name;
        std::size_t lines;
        std::size_t points;
        bool first_diverges; // explicit Euler at 1 ms
    };
    for (const Case &each :
         {Case{"integrators_vice", 7, 5 * 11 + 2 * 5, true},
          Case{"integrators_friction", 7, 5 * 7 + 2 * 6, true},
          Case{"plant_models", 2 * models, 2 * models * 7, false},
          Case{"motion_direction", 4, 4 * 5, false}, Case{"motion_stiffness", 4, 3 + 5, false},
          Case{"proxies_thin_plate", 3, 2 * 6 + 1, true},
          Case{"servo_rate_stiffness", 3, 3 * 7, false},
          Case{"servo_rate_direction", 3, 3 * 7, false}}) {
        SCOPED_TRACE(each.name);
        EXPECT_EQ(chart(each.name).name, each.name);
        EXPECT_EQ(lines(each.name).size(), each.lines);
        EXPECT_EQ(chart(each.name).points.size(), each.points);
        for (const ChartPoint &point : chart(each.name).points) {
            SCOPED_TRACE(point.method + ", " + point.setting);
            EXPECT_FALSE(point.setting.empty());
            EXPECT_TRUE(std::isfinite(point.error) || !point.stable);
            EXPECT_TRUE(point.stable || !std::isfinite(point.error) ||
                        !chart(each.name).name.starts_with("integrators"));
            EXPECT_TRUE(point.cost.min_ns > 0.0 || !point.stable);
            EXPECT_LE(point.cost.min_ns, point.cost.median_ns);
            EXPECT_LE(point.cost.median_ns, point.cost.max_ns);
        }
        if (each.first_diverges) {
            EXPECT_FALSE(chart(each.name).points.front().stable);
        }
    }
}

TEST(PlantModelChart, AFullerModelHasASmallerError) {
    auto of_models = lines("plant_models");
    const auto error_N = [&](const char *model) { return of_models.at(model).back().error; };
    EXPECT_LT(error_N("rigid_tip"), error_N("coupling"));
    EXPECT_LT(error_N("electromechanical"), error_N("rigid_tip"));
    // Friction alone does not reduce the error: the compliance of the structure is missing.
    EXPECT_NEAR(error_N("rigid_links"), error_N("electromechanical"), 0.05);
    EXPECT_LT(error_N("full"), 1e-3); // at 10 µs: below what a finger perceives
}

/// Also where nothing pushes sideways the planar model is as good as the whole.
TEST(PlantModelChart, ThePlanarModelIsAsGoodAndNoneDiverges) {
    auto of_models = lines("plant_models");
    for (const simulated::PlantModel &model : simulated::kPlantModels) {
        const std::string name(model.name);
        const std::vector<ChartPoint> &whole = of_models.at(name);
        const std::vector<ChartPoint> &planar = of_models.at(name + ", planar");
        for (std::size_t i = 0; i < whole.size(); ++i) {
            EXPECT_TRUE(whole[i].stable && planar[i].stable) << name << " " << whole[i].setting;
            EXPECT_NEAR(planar[i].error, whole[i].error, 1e-6) << name << " " << whole[i].setting;
        }
    }
}

TEST(MotionControlChart, FinerEncodersReduceTheErrorOfTheTransposeAndNotOfTheInverse) {
    for (const auto &[method, points] : lines("motion_direction")) {
        const bool is_inverse = method.starts_with("inverse");
        for (std::size_t i = 1; i < points.size(); ++i) { // each four times as fine
            const double ratio = points[i - 1].error / points[i].error;
            EXPECT_NEAR(ratio, is_inverse ? 1.0 : 4.0, is_inverse ? 0.05 : 1.5) << method;
        }
        if (is_inverse) {
            EXPECT_GT(points.back().error, 25.0); // the perceptible angle of the paper
        } else {
            EXPECT_LT(points.front().error, 0.2);
        }
    }
}

TEST(MotionControlChart, GlobalAlphaIsSofterThanOnTheFlyAndThatThanTheInverse) {
    auto of_methods = lines("motion_stiffness");
    const double inverse = of_methods["inverse (18)"].front().error;
    const double on_the_fly = of_methods["transpose (23), α on the fly"].front().error;
    const double global = of_methods["transpose, global α"].front().error;
    EXPECT_LT(inverse, on_the_fly); // (28)
    EXPECT_LT(on_the_fly, global);  // the global α is the minimum
    const std::vector<ChartPoint> &by_hand = of_methods["transpose, α by hand"];
    for (std::size_t i = 1; i < by_hand.size(); ++i) { // (27): twice the α, half the compliance
        EXPECT_NEAR(by_hand[i - 1].error / by_hand[i].error, 2.0, 1e-6);
        EXPECT_LE(by_hand[i].stable, by_hand[i - 1].stable);
    }
    EXPECT_TRUE(by_hand.front().stable);
    EXPECT_FALSE(by_hand.back().stable);
}

TEST(MotionControlChart, RefusesATuningWithoutStaticStiffness) {
    ChartSetting without = quick_setting();
    without.tuning.K_P_V_per_rad = 0.0;
    EXPECT_THROW((void)motion_direction_chart(without, [](double) {}), InputError);
    without = quick_setting();
    without.tuning.eta = 1.0;
    EXPECT_THROW((void)motion_stiffness_chart(without, [](double) {}), InputError);
}

TEST(ProxyChart, OnAThinPlateThePenaltyAlwaysFailsAndTheProxyIsExact) {
    for (const ChartPoint &point : chart("proxies_thin_plate").points) {
        const bool is_penalty = point.method.find("penalty") != std::string::npos;
        EXPECT_EQ(point.stable, !is_penalty) << point.method;
        if (!is_penalty) {
            EXPECT_LT(point.error, 1e-15) << point.method; // round-off of 50 mm
        }
    }
}

TEST(ServoRateChart, AFasterServoCostsMoreAndHasSmallerErrors) {
    for (const char *name : {"servo_rate_stiffness", "servo_rate_direction"}) {
        for (const auto &[method, points] : lines(name)) {
            EXPECT_EQ(points.front().setting, "250 Hz");
            EXPECT_EQ(points.back().setting, "20 kHz");
            for (std::size_t i = 1; i < points.size(); ++i) {
                SCOPED_TRACE(method + ' ' + points[i].setting);
                EXPECT_GT(points[i].cost.median_ns, points[i - 1].cost.median_ns);
                EXPECT_LT(points[i].error, points[i - 1].error);
                EXPECT_GE(points[i].stable, points[i - 1].stable);
            }
        }
    }
}

TEST(ChartCsv, HasARowForEachPoint) {
    SpeedAccuracyChart chart;
    chart.points = {{"one", "100 µs", {1.5, 2.0, 1e6}, 1e-17, true},
                    {"two", "", {0.0, 0.0, 0.0}, NAN, false},
                    {"a, \"b\"", "two\nlines", {1.0, 1.0, 1.0}, INFINITY, false}};
    std::ostringstream out;
    write_csv(out, chart_table(chart, "AMD EPYC (2 cores)"));
    EXPECT_EQ(out.str(),
              "method,setting,cost_least_ns,cost_median_ns,cost_greatest_ns,error,stable,machine\n"
              "one,100 µs,1.5,2,1e+06,1e-17,1,AMD EPYC (2 cores)\n"
              "two,,0,0,0,,0,AMD EPYC (2 cores)\n"
              "\"a, \"\"b\"\"\",\"two\nlines\",1,1,1,,0,AMD EPYC (2 cores)\n");
}

const IntegratorTrial &pen_trial() {
    static const IntegratorTrial trial(press_of(quick_setting(), rig::pen_press()));
    return trial;
}

const IntegratorTrial &vice_trial() {
    static const IntegratorTrial trial(press_of(quick_setting(), rig::vice_press()));
    return trial;
}

const IntegratorTrial &sticking_trial() {
    static const IntegratorTrial trial(press_of(quick_setting(), rig::sticking_press()));
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
    const rig::Scenario press = press_of(quick_setting(), rig::pen_press());
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
    ChartSetting braked = quick_setting();
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
    const rig::Scenario press = press_of(quick_setting(), rig::planar_press());
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

constexpr std::array<bool, 3> kNoneReleased{};

/// Masses of any ratio and any coupling that a positive definite matrix may have.
rig::PlantMechanics random_mechanics(std::mt19937_64 &random) {
    std::uniform_real_distribution<double> some(0.1, 2.0);
    std::uniform_real_distribution<double> share(-0.95, 0.95);
    rig::PlantMechanics made;
    made.inertia.axial_kg_m2 = some(random);
    made.inertia.two_kg_m2 = some(random);
    made.inertia.three_kg_m2 = some(random);
    made.inertia.coupling_kg_m2 =
        share(random) * std::sqrt(made.inertia.two_kg_m2 * made.inertia.three_kg_m2);
    made.torque_Nm = testing::random_vector(random, 2.0);
    return made;
}

/// The function that Gauss's principle of least constraint minimises: ½ aᵀ M a − τᵀ a + Σ τ_c |a|
/// for joints at rest.
double constraint(const rig::PlantMechanics &mechanics, const Vector3 &coulomb_Nm,
                  const Vector3 &acceleration) {
    const Matrix3 M = mechanics.inertia.matrix_kg_m2();
    return 0.5 * acceleration.dot(M * acceleration) - mechanics.torque_Nm.dot(acceleration) +
           coulomb_Nm.dot(acceleration.cwiseAbs());
}

TEST(StickSlipModes, FollowTheLeastConstraintFromRest) {
    const Vector3 coulomb_Nm(0.5, 0.7, 0.9);
    std::mt19937_64 random(611);
    int sticking = 0;
    int sliding = 0;
    for (int i = 0; i < 1000; ++i) {
        const rig::PlantMechanics mechanics = random_mechanics(random);
        const StickSlipModes modes =
            stick_slip_modes(mechanics, coulomb_Nm, Vector3::Zero(), kNoneReleased);
        const Vector3 a = stick_slip_motion(mechanics, coulomb_Nm, modes).acceleration_rad_per_s2;
        const double minimum = constraint(mechanics, coulomb_Nm, a);
        for (int trial = 0; trial < 20; ++trial) {
            const Vector3 other = a + testing::random_vector(random, trial < 10 ? 1e-3 : 1.0);
            ASSERT_GE(constraint(mechanics, coulomb_Nm, other),
                      minimum - 1e-14); // round-off of 1 J
        }
        for (std::size_t j = 0; j < 3; ++j) {
            ASSERT_EQ(modes[j] == 0, a[static_cast<Eigen::Index>(j)] == 0.0);
            (modes[j] == 0 ? sticking : sliding) += 1;
        }
    }
    EXPECT_GT(sticking, 100);
    EXPECT_GT(sliding, 100);
}

TEST(StickSlipModes, OfJointsThatMoveAreTheirDirections) {
    std::mt19937_64 random(612);
    const rig::PlantMechanics mechanics = random_mechanics(random);
    EXPECT_EQ(
        stick_slip_modes(mechanics, Vector3::Ones(), Vector3(1e-300, -2.0, 3.0), kNoneReleased),
        (StickSlipModes{1, -1, 1}));
}

/// A device without drive and with Coulomb friction only, pushed by a hand without mass.
struct Bare {
    device::DeviceDescription device = testing::phantom_1_0();
    simulated::SimulationOptions options;

    Bare() {
        for (device::MotorParameters &motor : device.motor) {
            motor.torque_constant_Nm_per_A = 1e-12;
        }
        options.hand = {0.0, 0.0, 0.0, 1e6, 1.0};
        options.effects = simulated::PlantEffects::none();
        options.effects.coulomb_friction = true;
    }
    [[nodiscard]] rig::PlantEquations equations(const Vector3 &target_m) const {
        rig::PlantEquations made(device, options);
        rig::PlantInputs inputs;
        inputs.target.position_m = target_m;
        made.set_inputs(inputs);
        return made;
    }
};

TEST(StickSlipSolver, ACoastingBaseStopsAtThePredictedPlaceAndStays) {
    // Slow enough for the links not to be thrown outwards: friction holds them.
    const Bare bare;
    const rig::PlantEquations equations = bare.equations(Vector3::Zero());
    const double rate = 0.05;
    rig::PlantState start = rig::PlantState::Zero();
    start[0] = 0.1;
    start[3] = rate;
    const double deceleration =
        bare.device.friction.coulomb_Nm[0] / equations.mechanics(0.0, start).inertia.axial_kg_m2;
    const double stops_s = rate / deceleration;
    StickSlipSolver solver(CvodeMethod::adams, 1e-12);
    for (const double share : {0.5, 0.99}) {
        const rig::PlantState y = solver.advance(equations, 0.0, share * stops_s, start);
        EXPECT_NEAR(y[3], (1.0 - share) * rate, 1e-11 * rate); // some hundred steps of 1e-12
    }
    const rig::PlantState stopped = solver.advance(equations, 0.0, 1.01 * stops_s, start);
    EXPECT_NEAR(stopped[0] - start[0], 0.5 * rate * stops_s, 1e-12); // of 0.1 rad
    EXPECT_EQ(stopped[3], 0.0);
    EXPECT_EQ(stopped.segment<2>(1), start.segment<2>(1));
    const rig::PlantState later = solver.advance(equations, 0.0, 1.0, stopped);
    EXPECT_EQ(later.head<6>(), stopped.head<6>());
}

TEST(StickSlipSolver, BreaksAwayAtTheTorqueOfFrictionAndNotBefore) {
    // A hand's spring pulls the tip sideways: k x l against τ_c at the base.
    Bare bare;
    bare.options.hand.stiffness_N_per_m = 1.0;
    const double reach_m = bare.device.geometry.upper_arm_m; // of the tip from the base's axis
    const double breaks_m = bare.device.friction.coulomb_Nm[0] / reach_m;
    StickSlipSolver solver(CvodeMethod::adams, 1e-12);
    const auto moved_rad = [&](double target_m) {
        return solver.advance(bare.equations(Vector3(target_m, 0.0, 0.0)), 0.0, 0.1,
                              rig::PlantState::Zero())[0];
    };
    for (const double side : {1.0, -1.0}) {
        EXPECT_EQ(moved_rad(0.999 * side * breaks_m), 0.0);
        EXPECT_GT(side * moved_rad(1.001 * side * breaks_m), 1e-6);
    }
}

} // namespace
} // namespace springdrive::charts
