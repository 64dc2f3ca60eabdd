// Covers engine/lab/rig/rotor_simulation.cpp.
#include "engine/lab/rig/rotor_simulation.h"

#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace springdrive::rig {
namespace {

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
