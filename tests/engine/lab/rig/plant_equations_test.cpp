// Covers engine/lab/rig/plant_equations.cpp and integrators.h.
#include "engine/lab/rig/plant_equations.h"

#include "device/core/phantom/kinematics.h"
#include "engine/lab/rig/integrators.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <random>

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

} // namespace
} // namespace springdrive::rig
