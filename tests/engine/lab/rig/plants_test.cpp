// Covers engine/lab/rig/plant_equations.cpp.
#include "engine/lab/rig/plant_equations.h"

#include "device/core/phantom/kinematics.h"
#include "engine/lab/rig/rotor_simulation.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <vector>

namespace springdrive::rig {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

struct Somewhere {
    PlantState y;
    PlantInputs inputs;
    double time_s = 0.0;
};

Somewhere random_place(const device::DeviceDescription &device, std::mt19937_64 &random) {
    Somewhere place;
    place.y << testing::random_workspace_angles(device, random),
        testing::random_vector(random, 5.0), testing::random_vector(random, 2.0);
    place.inputs.command.e_W_V = testing::random_vector(random, 1.0);
    place.inputs.command.cancelled_resistance_Ohm =
        Vector3::Constant(1.5) + testing::random_vector(random, 0.5);
    place.inputs.start_s = 0.3;
    place.inputs.target = {device::tip_position_m(device.geometry, place.y.head<3>()) +
                               testing::random_vector(random, 0.02),
                           testing::random_vector(random, 0.3)};
    place.time_s = 0.3007;
    return place;
}

simulated::SimulationOptions smooth() {
    simulated::SimulationOptions options;
    options.effects = simulated::PlantEffects::none();
    options.effects.gravity = true;
    options.effects.viscous_friction = true;
    return options;
}

class PlantRates : public ::testing::TestWithParam<device::DeviceDescription> {};

TEST_P(PlantRates, SatisfyTheEquationsOfTheDevice) {
    // What device/core/phantom says of masses, Coriolis torques, weight and kinematics, and (11).
    const device::DeviceDescription &device = GetParam();
    const simulated::SimulationOptions options = smooth();
    PlantEquations equations(device, options);
    const device::LinkageMoments moments = device::linkage_moments(
        device.geometry, device.inertia, device.inertia.tip_load_kg + options.hand.mass_kg);
    const device::LinkageMoments weight =
        device::linkage_moments(device.geometry, device.inertia, device.inertia.tip_load_kg);
    std::mt19937_64 random(91);
    for (int i = 0; i < 1000; ++i) {
        const Somewhere at = random_place(device, random);
        equations.set_inputs(at.inputs);
        const PlantState rate = equations.rates(at.time_s, at.y);
        const Vector3 q = at.y.head<3>();
        const Vector3 w = at.y.segment<3>(3);
        const Vector3 current_A = at.y.tail<3>();
        const Matrix3 J = device::joint_jacobian(device.geometry, q);
        const Vector3 target_m =
            at.inputs.target.position_m + 0.0007 * at.inputs.target.velocity_m_per_s;
        const Vector3 hand_N =
            options.hand.stiffness_N_per_m *
                (target_m - device::tip_position_m(device.geometry, q)) +
            options.hand.damping_Ns_per_m * (at.inputs.target.velocity_m_per_s - J * w);
        Matrix3 M = device::mass_matrix(moments, q);
        Vector3 motor_Nm;
        for (int j = 0; j < 3; ++j) {
            const device::MotorParameters &motor = device.motor[static_cast<std::size_t>(j)];
            const double N = device.geometry.transmission_ratio[j];
            const double k_T = motor.torque_constant_Nm_per_A;
            M(j, j) += N * N * motor.rotor_inertia_kg_m2;
            motor_Nm[j] = N * k_T * current_A[j];
            const double dR_Ohm =
                motor.resistance_Ohm - at.inputs.command.cancelled_resistance_Ohm[j];
            const double volts =
                at.inputs.command.e_W_V[j] - dR_Ohm * current_A[j] - k_T * N * w[j];
            ASSERT_NEAR(motor.inductance_H * rate[6 + j], volts, 1e-13); // of about 5 V
        }
        const Vector3 others_Nm =
            motor_Nm + J.transpose() * hand_N - device::coriolis_torque_Nm(moments, q, w) -
            device::gravity_torque_Nm(weight, q) - device.friction.viscous_Nms_per_rad * w;
        ASSERT_EQ(rate.head<3>(), w);
        // Torques of about 1 N·m, some tens of operations.
        ASSERT_LT((M * rate.segment<3>(3) - others_Nm).norm(), 100.0 * kEpsilon * 5.0);
    }
}

TEST_P(PlantRates, AreMadeOfTheirTwoParts) {
    PlantEquations equations(GetParam(), smooth());
    std::mt19937_64 random(92);
    for (int i = 0; i < 100; ++i) {
        const Somewhere at = random_place(GetParam(), random);
        equations.set_inputs(at.inputs);
        ASSERT_EQ(equations.rates(at.time_s, at.y),
                  equations.momentum_rates(at.time_s, at.y) + equations.position_rates(at.y));
    }
}

TEST_P(PlantRates, LoseWhatCoulombFrictionTakes) {
    const device::DeviceDescription &device = GetParam();
    simulated::SimulationOptions rough = smooth();
    rough.effects.coulomb_friction = true;
    PlantEquations without(device, smooth());
    PlantEquations jump(device, rough);
    PlantEquations soft(device, rough);
    const double width = 3.0;
    soft.set_friction_width(width);
    std::mt19937_64 random(94);
    for (int i = 0; i < 100; ++i) {
        Somewhere at = random_place(device, random);
        at.y[3] = 0.0; // this joint is at rest
        for (PlantEquations *one : {&without, &jump, &soft}) {
            one->set_inputs(at.inputs);
        }
        const Matrix3 M = without.mechanics(at.time_s, at.y).inertia.matrix_kg_m2();
        const auto taken_Nm = [&](const PlantEquations &equations) {
            return Vector3(
                M *
                (without.rates(at.time_s, at.y) - equations.rates(at.time_s, at.y)).segment<3>(3));
        };
        for (int j = 0; j < 3; ++j) {
            const double rate = at.y[3 + j];
            const double coulomb_Nm = device.friction.coulomb_Nm[j];
            const double sign = rate == 0.0 ? 0.0 : std::copysign(1.0, rate);
            // Differences of accelerations by torques of about 1 N·m.
            ASSERT_NEAR(taken_Nm(jump)[j], sign * coulomb_Nm, 1e-13);
            ASSERT_NEAR(taken_Nm(soft)[j], std::tanh(rate / width) * coulomb_Nm, 1e-13);
        }
    }
}

TEST_P(PlantRates, TheTipForceDoesTheMotorsWork) {
    const device::DeviceDescription &device = GetParam();
    const PlantEquations equations(device, smooth());
    std::mt19937_64 random(93);
    for (int i = 0; i < 100; ++i) {
        const Somewhere at = random_place(device, random);
        const Vector3 w = at.y.segment<3>(3);
        double motors_W = 0.0;
        for (int j = 0; j < 3; ++j) {
            motors_W += device.geometry.transmission_ratio[j] *
                        device.motor[static_cast<std::size_t>(j)].torque_constant_Nm_per_A *
                        at.y[6 + j] * w[j];
        }
        const Vector3 tip_rate = device::joint_jacobian(device.geometry, at.y.head<3>()) * w;
        ASSERT_NEAR(equations.tip_force_N(at.y).dot(tip_rate), motors_W, 1e-11); // of some watts
    }
}

INSTANTIATE_TEST_SUITE_P(Devices, PlantRates,
                         ::testing::Values(testing::phantom_1_0(), testing::phantom_premium_1_5()),
                         [](const auto &instance) {
                             return instance.param.geometry.upper_arm_m < 0.2 ? "Phantom10"
                                                                              : "Premium15";
                         });

using Scalar = Eigen::Matrix<double, 1, 1>;
using Pair = Eigen::Vector2d;

constexpr double kRoundOff = 20.0 * std::numeric_limits<double>::epsilon();

/// ẏ = λ y.
auto decay(double lambda) {
    return [lambda](double, const Scalar &y) { return Scalar(lambda * y); };
}

template <typename Rates> double midpoint(const Rates &f, double time_s, double y, double h) {
    ImplicitMidpoint<Scalar> method;
    method.prepare(f, time_s, Scalar(y), h);
    const std::optional<Scalar> next = method.step(f, time_s, Scalar(y));
    return next ? (*next)[0] : std::numeric_limits<double>::quiet_NaN();
}

TEST(Integrators, MultiplyALinearSystemByTheirStabilityFunctions) {
    for (const double z : {-3.0, -1.0, -0.1, 0.5}) {
        const double h = 0.25;
        const auto f = decay(z / h);
        const double euler = explicit_euler_step(f, 0.0, Scalar(1.0), h)[0];
        const double runge_kutta = runge_kutta_step(f, 0.0, Scalar(1.0), h)[0];
        EXPECT_NEAR(euler, 1.0 + z, kRoundOff);
        EXPECT_NEAR(runge_kutta, 1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0))),
                    kRoundOff);
        EXPECT_NEAR(midpoint(f, 0.0, 1.0, h), (1.0 + 0.5 * z) / (1.0 - 0.5 * z), kRoundOff);
    }
}

TEST(Integrators, MeetAnEquationOfTimeAtTheirOrders) {
    // ẏ = −2 t y² from y(0) = 1 is y = 1/(1 + t²).
    const auto f = [](double t, const Scalar &y) { return Scalar(-2.0 * t * y[0] * y[0]); };
    const auto error = [&](const auto &step, int steps) {
        const double h = 1.0 / steps;
        double y = 1.0;
        for (int i = 0; i < steps; ++i) {
            y = step(i * h, y, h);
        }
        return std::abs(y - 0.5);
    };
    const auto order = [&](const auto &step) {
        return std::log2(error(step, 64) / error(step, 128));
    };
    const auto euler = [&](double t, double y, double h) {
        return explicit_euler_step(f, t, Scalar(y), h)[0];
    };
    const auto runge_kutta = [&](double t, double y, double h) {
        return runge_kutta_step(f, t, Scalar(y), h)[0];
    };
    const auto implicit_midpoint = [&](double t, double y, double h) {
        return midpoint(f, t, y, h);
    };
    EXPECT_NEAR(order(euler), 1.0, 0.1);
    EXPECT_NEAR(order(runge_kutta), 4.0, 0.1);
    EXPECT_NEAR(order(implicit_midpoint), 2.0, 0.1);
}

/// q̇ = p, ṗ = −q.
Pair oscillator(double, const Pair &y) { return {y[1], -y[0]}; }

TEST(SemiImplicitEuler, KeepsTheEnergyThatIsItsOwn) {
    // q² + p² − h q p is constant, whatever h below 2.
    const double h = 0.3;
    const auto kick = [](double, const Pair &y) { return Pair(0.0, -y[0]); };
    const auto drift = [](double, const Pair &y) { return Pair(y[1], 0.0); };
    const auto energy = [h](const Pair &y) { return y.squaredNorm() - h * y[0] * y[1]; };
    Pair y(1.0, 0.2);
    const double start = energy(y);
    for (int i = 0; i < 10'000; ++i) {
        y = semi_implicit_euler_step(kick, drift, 0.0, y, h);
        ASSERT_NEAR(energy(y), start, 1e-12); // round-off, 10,000 times
    }
}

TEST(ImplicitMidpoint, KeepsAnOscillatorsEnergy) {
    ImplicitMidpoint<Pair> method;
    Pair y(1.0, 0.2);
    const double start = y.squaredNorm();
    method.prepare(oscillator, 0.0, y, 0.3);
    for (int i = 0; i < 10'000; ++i) {
        const std::optional<Pair> next = method.step(oscillator, 0.0, y);
        ASSERT_TRUE(next);
        y = *next;
        ASSERT_NEAR(y.squaredNorm(), start, 1e-12); // round-off, 10,000 times
    }
}

TEST(ImplicitMidpoint, SaysWhereItDoesNotSettle) {
    const auto f = [](double, const Scalar &) {
        return Scalar(std::numeric_limits<double>::quiet_NaN());
    };
    EXPECT_TRUE(std::isnan(midpoint(f, 0.0, 1.0, 0.1)));
}

RotorSimulationOptions locked_rotor() {
    RotorSimulationOptions options;
    options.motor = testing::phantom_1_0().motor[0];
    options.net_resistance_Ohm = 0.5;
    options.load.inertia_kg_m2 = 1e6;
    options.start_rad = 0.01;
    return options;
}

TEST(RotorSimulation, ALockedWindingFillsByItsTimeConstant) {
    for (const double dR : {2.0, 0.5, -0.1}) { // over-cancelled, too
        RotorSimulationOptions options = locked_rotor();
        options.net_resistance_Ohm = dR;
        options.per_position = -10.0;
        RotorSimulation rotor(options);
        for (int k = 1; k <= 5; ++k) {
            rotor.tick();
            const double truth =
                -0.1 / dR * -std::expm1(-dR / options.motor.inductance_H * 1e-3 * k);
            EXPECT_NEAR(rotor.current_A(), truth, 1e-9 * std::abs(truth)) << dR << " Ω";
        }
    }
}

/// A winding that is held fills from dT on, wherever in a period that is.
TEST(RotorSimulation, ADelaySplitsThePeriodExactly) {
    for (const double delay : {0.0, 1.0, 8.0, 0.001, 0.25, 0.5, 0.97, 1.3, 2.999, 7.5}) {
        RotorSimulationOptions options = locked_rotor();
        options.per_position = -10.0;
        options.delay_periods = delay;
        RotorSimulation rotor(options);
        for (int k = 1; k <= 12; ++k) {
            rotor.tick();
            const double time_s = 1e-3 * std::max(0.0, k - delay);
            const double truth =
                -0.1 / 0.5 * -std::expm1(-0.5 / options.motor.inductance_H * time_s);
            // The rotor of 1e6 kg·m² as good as stands, as above; round-off of 40 sub-steps.
            EXPECT_NEAR(rotor.current_A(), truth, 1e-9 * 0.2) << delay << ", " << k;
        }
    }
}

TEST(RotorSimulation, ACurrentDriveFollowsWithItsBandwidth) {
    RotorSimulationOptions options = locked_rotor();
    options.drive = device::AmplifierKind::current_drive;
    options.current_bandwidth_rad_per_s = 700.0;
    options.per_position = -10.0;
    RotorSimulation rotor(options);
    rotor.tick();
    EXPECT_NEAR(rotor.current_A(), -0.1 * -std::expm1(-0.7), 1e-9);
}

TEST(RotorSimulation, ReadsWholeCounts) {
    RotorSimulationOptions options = locked_rotor();
    options.per_position = -10.0;
    options.quantum_rad = 0.02;
    for (const double start : {0.0099, 0.0101, -0.0099, -0.0101, 0.0299}) {
        options.start_rad = start;
        RotorSimulation rotor(options);
        rotor.tick();
        const double read_rad = 0.02 * std::round(start / 0.02);
        const double truth =
            -10.0 * read_rad / 0.5 * -std::expm1(-0.5 / options.motor.inductance_H * 1e-3);
        EXPECT_NEAR(rotor.current_A(), truth, 1e-9) << start;
    }
}

TEST(RotorSimulation, TheSupplyEnds) {
    RotorSimulationOptions options = locked_rotor();
    options.per_position = -1e6;
    options.amplifier_limits = true;
    RotorSimulation rotor(options);
    for (int k = 0; k < 50; ++k) {
        rotor.tick();
        EXPECT_LE(std::abs(rotor.current_A()), options.motor.peak_current_A * (1.0 + 1e-3));
    }
    EXPECT_LT(rotor.current_A(), -0.9 * options.motor.peak_current_A);
}

/// A mass on a spring, nothing else: the motor is as good as cut off.
RotorSimulationOptions pendulum(double period_s) {
    RotorSimulationOptions options;
    options.motor = testing::phantom_1_0().motor[0];
    options.motor.torque_constant_Nm_per_A = 1e-12;
    options.net_resistance_Ohm = 0.5;
    options.load = {1e-5, 0.0, 40.0}; // 2000 rad/s
    options.period_s = period_s;
    options.start_rad = 1e-3;
    return options;
}

double swing(const RotorSimulationOptions &options, double time_s) {
    RotorSimulation rotor(options);
    const long ticks = std::lround(time_s / options.period_s);
    for (long k = 0; k < ticks; ++k) {
        rotor.tick();
    }
    return rotor.theta_rad();
}

TEST(RotorSimulation, IsOfSecondOrderInTheSubStep) {
    RotorSimulationOptions options = pendulum(50e-6); // one sub-step each
    options.load.damping_Nms_per_rad = 2e-3;
    const double decay = 2e-3 / (2.0 * 1e-5);
    const double w = std::sqrt(2000.0 * 2000.0 - decay * decay);
    constexpr double kTime_s = 2e-3;
    const double truth = 1e-3 * std::exp(-decay * kTime_s) *
                         (std::cos(w * kTime_s) + decay / w * std::sin(w * kTime_s));
    const auto miss = [&](double period_s) {
        options.period_s = period_s;
        return std::abs(swing(options, kTime_s) - truth);
    };
    const double coarse = miss(50e-6);
    EXPECT_LT(coarse, 5e-3 * 1e-3); // 4 rad of phase, (ωh)²/12 of it
    EXPECT_NEAR(std::log2(coarse / miss(25e-6)), 2.0, 0.05);
    EXPECT_NEAR(std::log2(miss(25e-6) / miss(12.5e-6)), 2.0, 0.05);
}

TEST(RotorSimulation, ADriveWithoutCommandsTakesTheEnergyThatItsResistanceHeats) {
    RotorSimulationOptions options = pendulum(10e-6);
    options.motor.torque_constant_Nm_per_A = 0.0234;
    options.load = {1e-5, 1e-4, 10.0};
    RotorSimulation rotor(options);
    const auto energy = [&] {
        return 0.5 * options.load.inertia_kg_m2 * rotor.rate_rad_per_s() * rotor.rate_rad_per_s() +
               0.5 * options.load.stiffness_Nm_per_rad * rotor.theta_rad() * rotor.theta_rad() +
               0.5 * options.motor.inductance_H * rotor.current_A() * rotor.current_A();
    };
    const double first = energy();
    double heat = 0.0;
    double before = first;
    for (int k = 0; k < 1000; ++k) {
        const double i = rotor.current_A();
        const double rate = rotor.rate_rad_per_s();
        rotor.tick();
        const auto mean_square = [](double a, double b) { return (a * a + a * b + b * b) / 3.0; };
        heat += 10e-6 * (0.5 * mean_square(i, rotor.current_A()) +
                         1e-4 * mean_square(rate, rotor.rate_rad_per_s()));
        EXPECT_LE(energy(), before * (1.0 + 1e-4)) << k;
        before = energy();
    }
    EXPECT_LT(energy(), 0.5 * first);
    EXPECT_NEAR(first - energy(), heat, 1e-3 * first); // (ωh)²: 1e-4 and more of winding
}

TEST(RotorSimulation, FrictionHoldsWhatPullsLess) {
    RotorSimulationOptions options = pendulum(1e-3);
    const double pull = options.load.stiffness_Nm_per_rad * options.start_rad;
    options.coulomb_Nm = 1.001 * pull;
    RotorSimulation held(options);
    options.coulomb_Nm = 0.999 * pull;
    RotorSimulation slips(options);
    for (int k = 0; k < 100; ++k) {
        held.tick();
        slips.tick();
    }
    EXPECT_EQ(held.theta_rad(), options.start_rad);
    EXPECT_EQ(held.rate_rad_per_s(), 0.0);
    EXPECT_LT(slips.theta_rad(), options.start_rad);
}

TEST(RotorSimulation, FrictionTakesTheSameFromEverySwing) {
    RotorSimulationOptions options = pendulum(20e-6);
    options.coulomb_Nm = 0.05 * 40.0 * 1e-3;
    RotorSimulation rotor(options);
    // Each half swing ends 2 F/k nearer, a tenth of the first: nine of them, then 0.05 to 0.1
    // remain. Turning points are where the rate changes its sign.
    double turning = options.start_rad;
    int turns = 0;
    double before = 0.0;
    for (int k = 0; k < 2000; ++k) {
        const double rate = rotor.rate_rad_per_s();
        const double theta = rotor.theta_rad();
        rotor.tick();
        if (before * rate < 0.0 || (before != 0.0 && rate == 0.0)) {
            ++turns;
            EXPECT_NEAR(std::abs(turning) - std::abs(theta), 1e-4, 3e-6) << turns; // one step
            turning = theta;
        }
        before = rate;
    }
    EXPECT_GE(turns, 9);
    EXPECT_LE(turns, 10);
    EXPECT_EQ(rotor.rate_rad_per_s(), 0.0);
    EXPECT_LE(std::abs(rotor.theta_rad()), options.coulomb_Nm / 40.0 * (1.0 + 1e-9));
}

} // namespace
} // namespace springdrive::rig
