// Covers cables between rotors and linkage: device/core/device_description.h, and of
// device/simulated the rotors on them. Against CVODE they are in plant_reference_test.cpp.
#include "base/input_error.h"
#include "device/core/device_description.h"
#include "device/core/phantom/dynamics.h"
#include "device/core/phantom/kinematics.h"
#include "device/simulated/plant_setup.h"
#include "device/simulated/simulated_phantom.h"
#include "device/simulated/simulation_options.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace springdrive::simulated {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Which sides of the structure are compliant.
struct Sides {
    bool cables = false;
    bool tip = false;

    [[nodiscard]] std::string name() const {
        return std::string(cables ? "cables " : "") + (tip ? "tip" : "");
    }
};
constexpr std::array<Sides, 4> kSides{{{false, false}, {false, true}, {true, false}, {true, true}}};

/// Nothing but links, rotors, windings and these; a hand that is a mass, if anything.
SimulationOptions compliant(Sides sides, double hand_kg = 0.1) {
    SimulationOptions options;
    options.effects = PlantEffects::none();
    options.effects.cable_compliance = sides.cables;
    options.effects.structural_compliance = sides.tip;
    options.hand = {hand_kg, 0.0, 0.0, 1e6, 1.0};
    return options;
}

device::DeviceDescription undamped() {
    device::DeviceDescription device = testing::phantom_1_0();
    device.structure.damping_Ns_per_m = 0.0;
    device.structure.cable_damping_ratio = 0.0;
    return device;
}

Vector3 twist_rad(const SimulatedPhantom &device) {
    return device.truth().theta_rad -
           device::motor_from_joint(device.description().geometry, device.truth().q_rad);
}

TEST(CableCompliance, SharesTheWholeWithTheTipsSide) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const Matrix3 J = device::motor_jacobian(device.geometry, device::default_pose_rad());
    for (const double share : {1e-6, 0.2, 0.7, 1.0}) {
        const std::array cables = device::cable_compliance(device, share);
        const device::StructuralCompliance tip = device::tip_compliance(device.structure, share);
        for (std::size_t j = 0; j < 3; ++j) {
            // A unit force along column j of J turns the rotor by |J_j|/κ, and the tip moves by
            // |J_j| of that.
            const double squared_m2 = J.col(static_cast<Eigen::Index>(j)).squaredNorm();
            const double cable_m_per_N = squared_m2 / cables[j].stiffness_Nm_per_rad;
            EXPECT_NEAR((cable_m_per_N + 1.0 / tip.stiffness_N_per_m) *
                            device.structure.stiffness_N_per_m,
                        1.0, 1e-14);
            // Critical damping of κ and J_m is 2 √(κ J_m).
            EXPECT_NEAR(
                cables[j].damping_Nms_per_rad * cables[j].damping_Nms_per_rad /
                    (4.0 * cables[j].stiffness_Nm_per_rad * device.motor[j].rotor_inertia_kg_m2),
                std::pow(device.structure.cable_damping_ratio, 2), 1e-15);
        }
        if (share < 1.0) {
            EXPECT_DOUBLE_EQ(tip.damping_Ns_per_m / tip.stiffness_N_per_m,
                             device.structure.damping_Ns_per_m /
                                 device.structure.stiffness_N_per_m);
        }
    }
}

TEST(CableCompliance, IsRigidWhereItHasNoShare) {
    for (const device::DeviceDescription &device : {testing::phantom_1_0(), undamped()}) {
        for (const device::CableCompliance &cable : device::cable_compliance(device, 0.0)) {
            EXPECT_EQ(cable.stiffness_Nm_per_rad, kInfinity);
            EXPECT_EQ(cable.damping_Nms_per_rad, kInfinity);
        }
        const device::StructuralCompliance tip = device::tip_compliance(device.structure, 1.0);
        EXPECT_EQ(tip.stiffness_N_per_m, kInfinity);
        EXPECT_EQ(tip.damping_Ns_per_m, kInfinity);
        EXPECT_EQ(device::tip_compliance(device.structure, 0.0).stiffness_N_per_m,
                  device.structure.stiffness_N_per_m);
    }
}

TEST(SimulatedCables, YieldAtTheTipByTheirShare) {
    device::DeviceDescription description = testing::phantom_1_0();
    const double K = description.structure.stiffness_N_per_m;
    constexpr double kCurrent_A = 1e-4; // so small that the pose stays
    const Matrix3 J = device::motor_jacobian(description.geometry, device::default_pose_rad());
    for (const double share : {0.25, 0.8, 1.0}) {
        description.structure.cable_share = share;
        for (Eigen::Index j = 0; j < 3; ++j) {
            SimulationOptions options = compliant({true, share < 1.0});
            options.amplifier = device::AmplifierKind::current_drive;
            options.hand = {0.1, 60.0, 1e4, 1e6, 1.0};
            SimulatedPhantom plant(
                description, options,
                device::tip_position_m(description.geometry, device::default_pose_rad()));
            PlantCommand command;
            command.current_A[j] = kCurrent_A;
            for (int k = 0; k < 2000; ++k) {
                plant.advance(command);
            }
            // Motor j alone holds the tip against the force F of the hand, Jᵀ F = −τ e_j.
            const double torque_Nm = kCurrent_A * description.motor[0].torque_constant_Nm_per_A;
            const Vector3 force_N = J.transpose().inverse() * (-torque_Nm * Vector3::Unit(j));
            const Vector3 along = J.col(j).normalized();
            const Vector3 rotors_m = device::tip_position_m(
                description.geometry,
                device::joint_from_motor(description.geometry, plant.truth().theta_rad));
            const Vector3 link_m =
                device::tip_position_m(description.geometry, plant.truth().q_rad);
            // 1e-4 A moves the pose by some 1e-6, relative to the links.
            const double tolerance_m = 1e-5 / K * force_N.norm();
            EXPECT_LT((plant.truth().hand_force_N - force_N).norm(), 1e-5 * force_N.norm());
            EXPECT_LT((link_m - rotors_m - share / K * along.dot(force_N) * along).norm(),
                      tolerance_m);
            EXPECT_LT((plant.truth().tip_m - link_m - (1.0 - share) / K * force_N).norm(),
                      tolerance_m);
            EXPECT_GT(along.dot(-force_N), 0.5 * force_N.norm());
        }
    }
}

/// Of x₊ = a x − b x₋, the sampled swing of one mode, by least squares.
struct Swing {
    double rate_rad_per_s = 0.0;
    double decay_per_s = 0.0;
};

Swing swing_of(const std::vector<double> &x, double period_s) {
    Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    for (std::size_t k = 1; k + 1 < x.size(); ++k) {
        const Eigen::Vector2d row(x[k], -x[k - 1]);
        squares += row * row.transpose();
        right += row * x[k + 1];
    }
    const Eigen::Vector2d fit = squares.inverse() * right;
    return {std::acos(0.5 * fit[0] / std::sqrt(fit[1])) / period_s,
            -0.5 * std::log(fit[1]) / period_s};
}

TEST(SimulatedCables, SwingAsRotorAndLinkOnOneCable) {
    const Vector3 decoupled_rad(0.1, 0.3, 0.3); // where the links are perpendicular
    for (const double ratio : {0.0, 0.03}) {
        device::DeviceDescription description = testing::phantom_1_0();
        description.structure.cable_damping_ratio = ratio;
        const device::PhantomGeometry &geometry = description.geometry;
        const Matrix3 M = device::mass_matrix(
            device::linkage_moments(geometry, description.inertia, 0.0), decoupled_rad);
        const Matrix3 J = device::motor_jacobian(geometry, device::default_pose_rad());
        SimulationOptions options = compliant({true, false}, 0.0);
        options.amplifier = device::AmplifierKind::current_drive;
        options.servo_period_s = 2.5e-4;
        options.longest_step_s = 2.5e-6;
        for (Eigen::Index j = 0; j < 3; ++j) {
            SimulatedPhantom plant(description, options,
                                   device::tip_position_m(geometry, decoupled_rad));
            PlantCommand kick;
            kick.current_A[j] = 1e-4; // so small that the joints do not act on each other
            plant.advance(kick);
            std::vector<double> twist;
            for (int k = 0; k < 80; ++k) {
                plant.advance(PlantCommand{});
                if (k >= 20) { // the current's own decay, of 80 µs, is over
                    twist.push_back(twist_rad(plant)[j]);
                }
            }
            const double N = geometry.transmission_ratio[j];
            const double mobility =
                1.0 / description.motor[0].rotor_inertia_kg_m2 + N * N / M(j, j);
            const double cable_Nm_per_rad =
                description.structure.stiffness_N_per_m * J.col(j).squaredNorm();
            const double squared = cable_Nm_per_rad * mobility;
            const double decay_per_s =
                ratio * std::sqrt(cable_Nm_per_rad * description.motor[0].rotor_inertia_kg_m2) *
                mobility;
            const Swing swing = swing_of(twist, options.servo_period_s);
            const double rate_rad_per_s = std::sqrt(squared - decay_per_s * decay_per_s);
            // Sub-steps turn a mode by 2 atan(hω/2): slower by a share of (hω)²/12 = 5e-6.
            EXPECT_NEAR(swing.rate_rad_per_s / rate_rad_per_s, 1.0, 1e-5);
            EXPECT_NEAR(swing.decay_per_s, decay_per_s, 1e-5 * rate_rad_per_s);
        }
    }
}

TEST(SimulatedCables, StoreTheWorkOfTheMotorsExactly) {
    // Constant currents do the work k_T i Δθ, and nothing dissipates.
    const device::DeviceDescription description = undamped();
    std::mt19937_64 random(91);
    for (const Sides sides : kSides) {
        for (int run = 0; run < 3; ++run) {
            SimulationOptions options = compliant(sides);
            options.amplifier = device::AmplifierKind::current_drive;
            options.effects.gravity = true;
            SimulatedPhantom plant(description, options, testing::kOffCentre_m);
            plant.set_in_motion(testing::random_vector(random, 1.0), Vector3::Zero());
            PlantCommand command;
            command.current_A = testing::random_vector(random, 0.05);
            for (int k = 0; k < 20; ++k) {
                plant.advance(command); // until the currents stand
            }
            const double start_J = plant.stored_energy_J();
            const Vector3 start_rad = plant.truth().theta_rad;
            double most_twist_rad = 0.0;
            for (int k = 0; k < 200; ++k) {
                plant.advance(command);
                const double work_J =
                    description.motor[0].torque_constant_Nm_per_A *
                    plant.truth().current_A.dot(plant.truth().theta_rad - start_rad);
                // 10,000 sub-steps whose round-off accumulates like a random walk.
                ASSERT_NEAR(plant.stored_energy_J() - start_J, work_J, 1e-13) << sides.name();
                most_twist_rad = std::max(most_twist_rad, twist_rad(plant).norm());
            }
            EXPECT_EQ(most_twist_rad > 1e-3, sides.cables);
            EXPECT_EQ(most_twist_rad > 1e-12, sides.cables);
        }
    }
}

TEST(SimulatedCables, NeverGainEnergyFromShortedWindings) {
    std::mt19937_64 random(92);
    for (int run = 0; run < 16; ++run) {
        SimulationOptions options;
        options.dynamics =
            run % 4 == 0 ? PlantDynamics::rigid_body : PlantDynamics::electromechanical;
        options.planar = run % 5 == 0;
        options.hand = {0.05, 0.0, 0.0, 0.0, 1.0};
        options.effects.cable_compliance = true;
        options.effects.structural_compliance = run % 2 == 0;
        options.effects.coulomb_friction = run % 3 != 0;
        options.device_seed = static_cast<std::uint64_t>(run);
        options.servo_period_s = 0.01;
        options.longest_step_s = 1e-3; // cables choose their own
        SimulatedPhantom plant(testing::phantom_1_0(), options, testing::kOffCentre_m);
        plant.set_in_motion(testing::random_vector(random, 6.0), Vector3::Zero());
        double before_J = plant.stored_energy_J();
        const double scale_J = std::abs(before_J) + 0.1;
        for (int k = 0; k < 100; ++k) {
            plant.advance(device::DeviceCommand::braking());
            const double now_J = plant.stored_energy_J();
            // Up to 500 sub-steps of some tens of operations each, every one of round-off ε.
            ASSERT_LE(now_J - before_J, 500 * 50 * std::numeric_limits<double>::epsilon() * scale_J)
                << "run " << run << " period " << k;
            before_J = now_J;
        }
    }
}

TEST(SimulatedCables, AreReadByEncodersAtTheRotors) {
    SimulationOptions options = compliant({true, false});
    options.quantised_encoders = false;
    SimulatedPhantom plant(testing::phantom_1_0(), options, testing::kOffCentre_m);
    plant.zero(Vector3::Zero());
    const Vector3 start_rad = plant.truth().theta_rad;
    device::Measurement state;
    for (int k = 0; k < 30; ++k) {
        state =
            plant.advance(device::DeviceCommand{Vector3(1.0, -1.0, 1.0), Vector3::Constant(1.6)});
    }
    const double rad_per_count = plant.description().rad_per_count();
    for (std::size_t j = 0; j < 3; ++j) {
        const auto index = static_cast<Eigen::Index>(j);
        EXPECT_NEAR(state.counts[j] * rad_per_count,
                    plant.truth().theta_rad[index] - start_rad[index], rad_per_count);
        EXPECT_GT(std::abs(twist_rad(plant)[index]), 1e3 * rad_per_count);
    }
}

constexpr double kDrivenCancelled_Ohm = 1.6;
Vector3 driven_V(int period) { return Vector3(0.2, -0.1, 0.15) * std::sin(0.3 * period); }

/// After 100 periods of drive, friction and weight.
SimulatedPhantom::Truth driven(const device::DeviceDescription &description,
                               SimulationOptions options) {
    options.effects.gravity = true;
    options.effects.viscous_friction = true;
    options.hand = {0.1, 6.0, 300.0, 5.0, 1.0};
    SimulatedPhantom plant(description, options, testing::kOffCentre_m);
    for (int k = 0; k < 100; ++k) {
        plant.advance(device::DeviceCommand{driven_V(k), Vector3::Constant(kDrivenCancelled_Ohm)});
    }
    return plant.truth();
}

TEST(SimulatedCables, OfAllOrNoneOfTheComplianceAreTheOtherEffectAlone) {
    device::DeviceDescription description = testing::phantom_1_0();
    for (const double share : {0.0, 1.0}) {
        description.structure.cable_share = share;
        const auto both = driven(description, compliant({true, true}));
        const auto one = driven(description, compliant({share == 1.0, share == 0.0}));
        const auto other = driven(description, compliant({share == 0.0, share == 1.0}));
        EXPECT_EQ(both.theta_rad, one.theta_rad);
        EXPECT_EQ(both.q_rad, one.q_rad);
        EXPECT_EQ(both.tip_m, one.tip_m);
        EXPECT_EQ(both.current_A, one.current_A);
        EXPECT_GT((both.theta_rad - other.theta_rad).norm(), 1e-4);
    }
}

TEST(SimulatedCables, AreRigidInTheLimit) {
    // As 1/K: halved, so is the difference.
    device::DeviceDescription description = testing::phantom_1_0();
    description.structure.cable_damping_ratio = 0.5; // without the swing, which has no limit
    const auto away_rad = [&](double stiffer) {
        device::DeviceDescription stiff = description;
        stiff.structure.stiffness_N_per_m *= stiffer;
        SimulationOptions options = compliant({true, false});
        options.longest_step_s = 10e-6;
        const Vector3 cabled_rad = driven(stiff, options).theta_rad;
        options.effects.cable_compliance = false;
        return (cabled_rad - driven(stiff, options).theta_rad).norm();
    };
    EXPECT_NEAR(std::log2(away_rad(32.0) / away_rad(64.0)), 1.0, 0.1);
}

TEST(SimulatedCables, OnRotorsWithoutInductanceAreItsLimit) {
    device::DeviceDescription description = testing::phantom_1_0();
    SimulationOptions options = compliant({true, true});
    options.longest_step_s = 5e-6;
    options.dynamics = PlantDynamics::rigid_body;
    const SimulatedPhantom::Truth at_once = driven(description, options);
    // The rotors' back-EMF, not that of the joints.
    const Vector3 sum_V = kDrivenCancelled_Ohm * at_once.current_A + driven_V(99);
    const device::MotorParameters &motor = description.motor[0];
    const Vector3 needed_V = motor.resistance_Ohm * at_once.current_A +
                             motor.torque_constant_Nm_per_A * at_once.theta_rate_rad_per_s;
    EXPECT_LT((sum_V - needed_V).norm(), 1e-12);
    const Vector3 twist_rate =
        at_once.theta_rate_rad_per_s -
        device::motor_from_joint(description.geometry, at_once.q_rate_rad_per_s);
    EXPECT_GT(twist_rate.norm(), 1e-3);
    options.dynamics = PlantDynamics::electromechanical;
    const auto away_m = [&](double share) {
        device::DeviceDescription quick = description;
        for (device::MotorParameters &winding : quick.motor) {
            winding.inductance_H *= share;
        }
        return (driven(quick, options).tip_m - at_once.tip_m).norm();
    };
    EXPECT_NEAR(std::log2(away_m(1.0 / 16.0) / away_m(1.0 / 32.0)), 1.0, 0.1);
}

TEST(SimulatedCables, InAPlaneAreThoseOfTheWholeDevice) {
    for (const bool tip : {false, true}) {
        SimulationOptions options = compliant({true, tip});
        options.hand.stiffness_N_per_m = 300.0;
        SimulatedPhantom whole(testing::phantom_1_0(), options, Vector3(0.0, 0.03, 0.01));
        options.planar = true;
        SimulatedPhantom plane(testing::phantom_1_0(), options, Vector3(0.0, 0.03, 0.01));
        for (int k = 0; k < 40; ++k) {
            const device::DeviceCommand push{Vector3(0.0, 0.5, -0.4), Vector3::Constant(1.6)};
            whole.advance(push);
            plane.advance(push);
            // 700 sub-steps, each with round-off in angles and currents of about 1.
            ASSERT_LT((whole.truth().theta_rad - plane.truth().theta_rad).norm(), 1e-12);
            ASSERT_LT((whole.truth().q_rad - plane.truth().q_rad).norm(), 1e-12);
        }
        EXPECT_GT(twist_rad(plane).norm(), 1e-3);
        EXPECT_EQ(plane.truth().theta_rate_rad_per_s[0], 0.0);
    }
}

TEST(SimulatedCables, ShortenSubStepsToWhatSwingsOnThem) {
    device::DeviceDescription description = testing::phantom_1_0();
    const auto step_s = [&](double stiffness_N_per_m, Sides sides) {
        description.structure.stiffness_N_per_m = stiffness_N_per_m;
        return plant_parts(description, compliant(sides)).longest_step_s;
    };
    const double usual_s = SimulationOptions{}.longest_step_s;
    EXPECT_EQ(step_s(3500.0, {false, true}), usual_s);
    EXPECT_EQ(step_s(350.0, {true, false}), usual_s);
    EXPECT_EQ(step_s(1e7, {true, false}), 20e-6);
    // The third rotor, and the second, are faster than the base's.
    const device::MotorParameters &motor = description.motor[2];
    const double arm_m =
        device::motor_jacobian(description.geometry, device::default_pose_rad()).col(2).norm();
    const double cable_Nm_per_rad = 35e3 * arm_m * arm_m;
    const double winding_Nm_per_rad =
        motor.torque_constant_Nm_per_A * motor.torque_constant_Nm_per_A / motor.inductance_H;
    const double with_winding_s = step_s(35e3, {true, false});
    EXPECT_LT(with_winding_s, usual_s);
    EXPECT_NEAR(with_winding_s *
                    std::sqrt((cable_Nm_per_rad + winding_Nm_per_rad) / motor.rotor_inertia_kg_m2),
                0.25, 1e-12);
    SimulationOptions at_once = compliant({true, false});
    at_once.dynamics = PlantDynamics::rigid_body;
    at_once.longest_step_s = 1.0;
    EXPECT_NEAR(plant_parts(description, at_once).longest_step_s *
                    std::sqrt(cable_Nm_per_rad / motor.rotor_inertia_kg_m2),
                0.25, 1e-12);
}

TEST(SimulatedCables, HaveTheFilesShareOrADrawnOne) {
    device::DeviceDescription known = testing::phantom_1_0();
    const device::DeviceDescription unknown = known;
    known.structure.cable_share = 0.3;
    EXPECT_EQ(sampled_device(unknown, 0).cable_share, 0.5);
    EXPECT_EQ(sampled_device(known, 0).cable_share, 0.3);
    double sum = 0.0;
    double least = 1.0;
    double most = 0.0;
    constexpr int kSeeds = 2000;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        const SampledDevice drawn = sampled_device(unknown, seed);
        sum += drawn.cable_share;
        least = std::min(least, drawn.cable_share);
        most = std::max(most, drawn.cable_share);
        const SampledDevice told = sampled_device(known, seed);
        ASSERT_EQ(told.cable_share, 0.3);
        ASSERT_EQ(told.motor[2].torque_ripple_phase_rad, drawn.motor[2].torque_ripple_phase_rad);
    }
    // Uniform: its mean has a standard deviation of 1/√(12 · 2000) = 0.0065, of which these are 4;
    // none of 2000 is within 1 % of an end in 1 of 10⁸ cases.
    EXPECT_NEAR(sum / kSeeds, 0.5, 0.026);
    EXPECT_GE(least, 0.0);
    EXPECT_LT(least, 0.01);
    EXPECT_LE(most, 1.0);
    EXPECT_GT(most, 0.99);
}

TEST(SimulatedCables, NeedMasses) {
    SimulationOptions options = compliant({true, false});
    options.dynamics = PlantDynamics::coupling;
    try {
        SimulatedPhantom plant(testing::phantom_1_0(), options, testing::kOffCentre_m);
        FAIL();
    } catch (const InputError &error) {
        EXPECT_NE(std::string(error.what()).find("cable_compliance"), std::string::npos);
    }
}

// Exchange while the device runs.

TEST(CableExchange, MovesNoEncoderAndRaisesNoEnergy) {
    std::mt19937_64 random(93);
    constexpr double kInstant_s = 1e-9;
    for (const Sides from : kSides) {
        for (const Sides to : kSides) {
            SimulationOptions options = compliant(from);
            options.effects.gravity = true;
            options.hand = {0.1, 6.0, 300.0, 5.0, 1.0};
            SimulatedPhantom plant(testing::phantom_1_0(), options, testing::kOffCentre_m);
            plant.set_hand_target(testing::kOffCentre_m + testing::random_vector(random, 0.02));
            const device::DeviceCommand push{testing::random_vector(random, 0.5),
                                             Vector3::Constant(1.6)};
            for (int k = 0; k < 57; ++k) {
                plant.advance(push);
            }
            const SimulatedPhantom::Truth before = plant.truth();
            const double before_J = plant.stored_energy_J();
            plant.set_period(kInstant_s);
            options.effects.cable_compliance = to.cables;
            options.effects.structural_compliance = to.tip;
            plant.simulate_as(options);
            plant.advance(push);
            const SimulatedPhantom::Truth &after = plant.truth();
            const std::string what = from.name() + " to " + to.name();
            // In a nanosecond nothing turns by a nanoradian, at some rad/s; joules change by some
            // nanowatt-seconds at some watts.
            EXPECT_LT((after.theta_rad - before.theta_rad).norm(), 1e-7) << what;
            EXPECT_LT((after.q_rad - before.q_rad).norm(), 1e-7) << what;
            EXPECT_LT(plant.stored_energy_J(), before_J + 1e-8) << what;
            if (from.cables == to.cables && from.tip == to.tip) {
                EXPECT_NEAR(plant.stored_energy_J(), before_J, 1e-8);
                EXPECT_LT((after.tip_m - before.tip_m).norm(), 1e-8);
            }
            if (to.cables && !from.cables && !from.tip && !to.tip) {
                EXPECT_NEAR(plant.stored_energy_J(), before_J, 1e-8); // no load on a new cable
            }
            if (from.cables && !to.cables && !from.tip && !to.tip) {
                EXPECT_LT(plant.stored_energy_J(), before_J - 1e-7) << what; // of the twist
            }
        }
    }
}

TEST(CableExchange, AJoinedRotorGivesItsMomentumToTheLinkage) {
    const device::DeviceDescription description = undamped();
    SimulationOptions options = compliant({true, false});
    options.amplifier = device::AmplifierKind::current_drive;
    SimulatedPhantom plant(description, options, testing::kOffCentre_m);
    PlantCommand command;
    command.current_A = {0.3, -0.2, 0.4};
    for (int k = 0; k < 23; ++k) {
        plant.advance(command);
    }
    const SimulatedPhantom::Truth before = plant.truth();
    plant.set_period(1e-9);
    options.effects.cable_compliance = false;
    plant.simulate_as(options);
    plant.advance(command);
    const SimulatedPhantom::Truth &after = plant.truth();
    const Vector3 &N = description.geometry.transmission_ratio;
    const Matrix3 M = device::mass_matrix(
        device::linkage_moments(description.geometry, description.inertia, options.hand.mass_kg),
        before.q_rad);
    const Vector3 rotors =
        description.motor[0].rotor_inertia_kg_m2 * N.cwiseProduct(before.theta_rate_rad_per_s);
    const Vector3 joined = description.motor[0].rotor_inertia_kg_m2 *
                           N.cwiseProduct(N.cwiseProduct(after.q_rate_rad_per_s));
    const Vector3 momentum = M * before.q_rate_rad_per_s + rotors;
    EXPECT_LT((M * after.q_rate_rad_per_s + joined - momentum).norm(), 1e-6 * momentum.norm());
    EXPECT_GT((after.theta_rate_rad_per_s - before.theta_rate_rad_per_s).norm(), 1.0);
    EXPECT_LT((after.tip_velocity_m_per_s -
               device::joint_jacobian(description.geometry, after.q_rad) * after.q_rate_rad_per_s)
                  .norm(),
              1e-12);
}

TEST(CableExchange, RestsWhereTheNewModelWouldRest) {
    const device::DeviceCommand push{Vector3(0.05, -0.04, 0.03), Vector3::Constant(1.5)};
    for (const Sides from : kSides) {
        for (const Sides to : kSides) {
            SimulationOptions before = compliant(from);
            SimulationOptions after = compliant(to);
            for (SimulationOptions *options : {&before, &after}) {
                options->effects.gravity = true;
                options->hand = {0.1, 6.0, 300.0, 5.0, 1.0};
            }
            SimulatedPhantom changed(testing::phantom_1_0(), before, testing::kOffCentre_m);
            SimulatedPhantom fresh(testing::phantom_1_0(), after, testing::kOffCentre_m);
            for (int k = 0; k < 3000; ++k) {
                changed.advance(push);
                fresh.advance(push);
                if (k == 300) {
                    changed.simulate_as(after);
                }
            }
            const std::string what = from.name() + " to " + to.name();
            EXPECT_LT((changed.truth().tip_m - fresh.truth().tip_m).norm(), 1e-7) << what;
            // What is left of a twist of some 10 mrad fades by e^(−13).
            EXPECT_LT((changed.truth().theta_rad - fresh.truth().theta_rad).norm(), 1e-6) << what;
        }
    }
}

} // namespace
} // namespace springdrive::simulated
