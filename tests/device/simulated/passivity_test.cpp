// Covers device/simulated/simulated_phantom.cpp and linkage_step.cpp: without a source
// the plant never gains energy, and friction holds loads below breakaway.
#include "device/simulated/simulated_phantom.h"

#include "device/core/phantom/kinematics.h"
#include "device/simulated/plant_setup.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

namespace springdrive::simulated {
namespace {

/// A free tip with a mass `mass_kg`.
SimulationOptions free_running(double mass_kg) {
    SimulationOptions options;
    options.hand = {mass_kg, 0.0, 0.0, 0.0, 1.0};
    return options;
}

/// A path that stays at one point.
HandPath at(const Vector3 &target_m) { return HandPath({{0.0, target_m}}); }

/// A reachable position in the workspace.
Vector3 random_place(std::mt19937_64 &random, const device::DeviceDescription &device) {
    while (true) {
        const Vector3 q_rad = testing::random_workspace_angles(device, random);
        if (device.joint_limits.allow(q_rad)) {
            return device::tip_position_m(device.geometry, q_rad);
        }
    }
}

class FreeRunning : public ::testing::TestWithParam<device::AmplifierKind> {};

TEST_P(FreeRunning, NeverGainsEnergyIn10Seconds) {
    std::mt19937_64 random(11);
    for (int run = 0; run < 100; ++run) {
        const device::DeviceDescription description =
            run % 2 == 0 ? testing::phantom_1_0() : testing::phantom_premium_1_5();
        SimulationOptions options = free_running(0.05);
        options.amplifier = GetParam();
        options.servo_period_s = 0.01;
        options.longest_step_s = 1e-3; // ten times the default: the claim holds for any step
        options.effects.structural_compliance = run % 3 == 0;
        options.effects.gravity = run % 5 != 0;
        if (run % 4 == 0) { // no dissipation other than in the windings
            options.effects.viscous_friction = false;
            options.effects.coulomb_friction = false;
        }
        SimulatedPhantom device(description, options, random_place(random, description));
        const bool shorted = GetParam() == device::AmplifierKind::spring_drive;
        device.set_in_motion(testing::random_vector(random, 6.0),
                             shorted ? testing::random_vector(random, 2.0) : Vector3::Zero());

        double before_J = device.stored_energy_J();
        // Magnitude of the terms of the energy: kinetic and, up to 0.1 J, gravity.
        const double scale_J = std::abs(before_J) + 0.1;
        double total_rise_J = 0.0;
        for (int k = 0; k < 1000; ++k) {
            device.advance(device::DeviceCommand::braking());
            const double now_J = device.stored_energy_J();
            // 10 sub-steps of some tens of operations each, every one of round-off ε.
            ASSERT_LE(now_J - before_J, 10 * 50 * std::numeric_limits<double>::epsilon() * scale_J)
                << "run " << run << " period " << k;
            total_rise_J += std::max(0.0, now_J - before_J);
            before_J = now_J;
        }
        // A tenth of what the bound for one period would allow over a thousand.
        EXPECT_LE(total_rise_J, 1e-11 * scale_J) << "run " << run;
    }
}

INSTANTIATE_TEST_SUITE_P(Windings, FreeRunning,
                         ::testing::Values(device::AmplifierKind::current_drive,
                                           device::AmplifierKind::spring_drive),
                         [](const auto &instance) {
                             return instance.param == device::AmplifierKind::current_drive
                                        ? "Undriven"
                                        : "Shorted";
                         });

TEST(Lossless, MotionsTooFastForTheStepAreSubdivided) {
    // 300 rad/s with half a kilogramme, ten times the default step: the iteration does not converge
    // for a single step.
    device::DeviceDescription description = testing::phantom_premium_1_5();
    description.inertia.tip_load_kg = 0.5;
    SimulationOptions options = free_running(0.0);
    options.amplifier = device::AmplifierKind::current_drive;
    options.effects = PlantEffects::none();
    options.longest_step_s = 1e-3;
    SimulatedPhantom device(description, options,
                            device::tip_position_m(description.geometry, Vector3(0.1, 0.2, 0.1)));
    device.set_in_motion(300.0 * Vector3(0.6, 0.64, -0.48), Vector3::Zero());
    const double initial_J = device.stored_energy_J();
    for (int k = 0; k < 1000; ++k) {
        device.advance(device::DeviceCommand::braking());
        ASSERT_LE(device.stored_energy_J(), initial_J * (1.0 + 1e-12)) << "period " << k;
    }
    EXPECT_NEAR(device.stored_energy_J(), initial_J, 1e-9 * initial_J);
}

TEST(LinkageStep, ReportsTheMotionOfJointsAndTipAlsoWhenSubdivided) {
    // This motion drives a tip behind a compliant structure. The faster motion is divided into
    // smaller steps, as above.
    device::DeviceDescription description = testing::phantom_premium_1_5();
    description.inertia.tip_load_kg = 0.5;
    SimulationOptions options = free_running(0.0);
    options.effects = PlantEffects::none();
    const LinkagePlant plant = plant_parts(description, options).linkage;
    constexpr double kStep_s = 1e-3;
    for (const double rate_rad_per_s : {3.0, 300.0}) {
        const LinkageState before{Vector3(0.1, 0.2, 0.1),
                                  rate_rad_per_s * Vector3(0.6, 0.64, -0.48)};
        std::array<FrictionMode, 3> modes{};
        const LinkageMotion motion = linkage_step(plant, before, {}, kStep_s, modes);
        EXPECT_GT(motion.after.rate_rad_per_s.norm(), 0.1 * rate_rad_per_s);
        const Vector3 way_m = device::tip_position_m(plant.geometry, motion.after.q_rad) -
                              device::tip_position_m(plant.geometry, before.q_rad);
        EXPECT_LT((kStep_s * motion.mean_tip_velocity_m_per_s - way_m).norm(), 1e-12);
        const Vector3 turned_rad = motion.after.q_rad - before.q_rad;
        EXPECT_LT((kStep_s * motion.mean_rate_rad_per_s - turned_rad).norm(), 1e-12);
    }
}

TEST(Lossless, FreeMotionConservesEnergy) {
    std::mt19937_64 random(12);
    SimulationOptions options = free_running(0.0);
    options.amplifier = device::AmplifierKind::current_drive; // zero current command: open windings
    options.effects = PlantEffects::none();
    options.effects.gravity = true;
    for (int run = 0; run < 5; ++run) {
        SimulatedPhantom device(testing::phantom_1_0(), options,
                                random_place(random, testing::phantom_1_0()));
        device.set_in_motion(testing::random_vector(random, 6.0), Vector3::Zero());
        const double initial_J = device.stored_energy_J();
        for (int k = 0; k < 1000; ++k) {
            device.advance(device::DeviceCommand::braking());
            // 100,000 sub-steps whose round-off accumulates like a random walk.
            ASSERT_NEAR(device.stored_energy_J(), initial_J, 1e-12 * (std::abs(initial_J) + 0.1));
        }
    }
}

/// A hand that pulls with a constant force, and its device without weight.
SimulationOptions pulled(const Vector3 &force_N) {
    constexpr double kSpring_N_per_m = 1e-3; // so soft that the tip's displacement does not matter
    SimulationOptions options;
    options.effects.gravity = false;
    options.hand = {0.0, 0.0, kSpring_N_per_m, 100.0, 1.0};
    options.path = at(testing::kOffCentre_m + force_N / kSpring_N_per_m);
    return options;
}

/// The joints' share of their breakaway torque under a force at the tip, the largest.
double load_share(const device::DeviceDescription &device, const Vector3 &force_N) {
    const Vector3 q_rad = *device::joint_angles_rad(device.geometry, testing::kOffCentre_m);
    const Vector3 torque_Nm = device::joint_jacobian(device.geometry, q_rad).transpose() * force_N;
    return torque_Nm.cwiseAbs().cwiseQuotient(device.friction.coulomb_Nm).maxCoeff();
}

TEST(JointFriction, HoldsLoadsBelowBreakawayExactlyForAMinute) {
    const device::DeviceDescription description = testing::phantom_1_0();
    std::mt19937_64 random(3);
    std::normal_distribution<double> one;
    for (int run = 0; run < 3; ++run) {
        Vector3 force_N(one(random), one(random), one(random));
        force_N *= 0.99 / load_share(description, force_N);
        SimulationOptions options = pulled(force_N);
        options.longest_step_s = 5e-4;
        SimulatedPhantom device(description, options, testing::kOffCentre_m);
        const Vector3 start_rad = device.truth().theta_rad;
        const device::Measurement first = device.advance(device::DeviceCommand::braking());
        for (int k = 0; k < 60'000; ++k) {
            ASSERT_EQ(device.advance(device::DeviceCommand::braking()).counts, first.counts);
        }
        EXPECT_EQ(device.truth().theta_rad, start_rad);
        EXPECT_EQ(device.truth().theta_rate_rad_per_s, Vector3::Zero());
    }
}

TEST(JointFriction, SlipsAboveBreakaway) {
    const device::DeviceDescription description = testing::phantom_1_0();
    for (const double share : {0.999, 1.001}) {
        Vector3 force_N(0.3, 1.0, -0.2);
        force_N *= share / load_share(description, force_N);
        SimulatedPhantom device(description, pulled(force_N), testing::kOffCentre_m);
        const Vector3 start_rad = device.truth().theta_rad;
        for (int k = 0; k < 1000; ++k) {
            device.advance(device::DeviceCommand::braking());
        }
        EXPECT_EQ(device.truth().theta_rad != start_rad, share > 1.0);
    }
}

TEST(JointFriction, AnOscillationStopsAndStaysExactlyAtRest) {
    // With weight, held by a hand: after the oscillation has decayed, friction balances hand and
    // gravity without chatter.
    SimulationOptions options;
    options.path = at(testing::kOffCentre_m);
    SimulatedPhantom device(testing::phantom_1_0(), options, testing::kOffCentre_m);
    device.set_in_motion(Vector3(2.0, -3.0, 2.5), Vector3::Zero());
    for (int k = 0; k < 3000; ++k) {
        device.advance(device::DeviceCommand::braking());
    }
    const Vector3 rest_rad = device.truth().theta_rad;
    for (int k = 0; k < 3000; ++k) {
        device.advance(device::DeviceCommand::braking());
        ASSERT_EQ(device.truth().theta_rad, rest_rad);
        ASSERT_EQ(device.truth().theta_rate_rad_per_s, Vector3::Zero());
    }
}

TEST(JointFriction, CoastingJointsDissipateTorqueTimesAngle) {
    // Coulomb friction alone dissipates τ_c |Δq| at every joint that turns.
    SimulationOptions options = free_running(0.0);
    options.amplifier = device::AmplifierKind::current_drive;
    options.effects = PlantEffects::none();
    options.effects.coulomb_friction = true;
    SimulatedPhantom device(testing::phantom_1_0(), options, testing::kOffCentre_m);
    device.set_in_motion(Vector3(0.6, 0.0, 0.0), Vector3::Zero());
    const double initial_J = device.stored_energy_J();
    const Vector3 &coulomb_Nm = device.description().friction.coulomb_Nm;
    Vector3 way_rad = Vector3::Zero();
    Vector3 before_rad = device.truth().theta_rad;
    for (int k = 0; k < 400; ++k) {
        device.advance(device::DeviceCommand::braking());
        way_rad += (device.truth().theta_rad - before_rad).cwiseAbs();
        before_rad = device.truth().theta_rad;
    }
    EXPECT_EQ(device.truth().theta_rate_rad_per_s, Vector3::Zero());
    const double lost_J =
        coulomb_Nm.dot(device::joint_from_motor(device.description().geometry, way_rad));
    // Exact except for the sub-step in which a joint stops, h = 100 µs of 0.1 s.
    EXPECT_NEAR(lost_J / initial_J, 1.0, 1e-3);
}

TEST(JointStops, StopAFallingLinkage) {
    SimulationOptions options = free_running(0.2);
    SimulatedPhantom device(testing::phantom_1_0(), options, testing::kOffCentre_m);
    const double at_rest_J = device.stored_energy_J();
    device.set_in_motion(Vector3(8.0, 5.0, -5.0), Vector3::Zero());
    const double kinetic_J = device.stored_energy_J() - at_rest_J;
    const device::JointLimits &limits = device.description().joint_limits;
    double deepest_rad = 0.0;
    for (int k = 0; k < 5000; ++k) {
        device.advance(device::DeviceCommand::braking());
        const Vector3 q =
            device::joint_from_motor(device.description().geometry, device.truth().theta_rad);
        deepest_rad = std::max(
            {deepest_rad, (q - limits.max_rad).maxCoeff(), (limits.min_rad - q).maxCoeff(),
             q[2] - q[1] - limits.max_q3_minus_q2_rad, limits.min_q3_minus_q2_rad - (q[2] - q[1])});
    }
    EXPECT_GT(deepest_rad, 0.0); // it reached one
    // The whole initial energy plus 0.1 J of gravity, stored in a spring of 100 N·m/rad.
    EXPECT_LT(deepest_rad, std::sqrt(2.0 * (kinetic_J + 0.1) / 100.0));
}

} // namespace
} // namespace springdrive::simulated
