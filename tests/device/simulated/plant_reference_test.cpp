// Covers device/simulated/simulated_phantom.cpp and linkage_step.cpp against independent truth:
// CVODE, and the balance of energy.
#include "device/simulated/simulated_phantom.h"

#include "device/core/phantom/kinematics.h"
#include "device/simulated/plant_setup.h"
#include "tests/support/configurations.h"
#include "tests/support/cvode.h"
#include "tests/support/devices.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <ostream>
#include <random>
#include <string>

namespace springdrive::simulated {
namespace {

// Covers device/simulated/simulated_phantom.cpp against CVODE.

using Eigen::VectorXd;

constexpr double kPeriod_s = 1e-3;
constexpr int kReferencePeriods = 50;
const double kStep_s = SimulationOptions{}.longest_step_s;

/// One motion of the whole plant, with every effect smooth.
struct Trial {
    device::DeviceDescription device = testing::phantom_1_0();
    SimulationOptions options;
    device::DeviceCommand command;
    Vector3 start_q_rad{Vector3::Zero()};
    Vector3 start_rate{Vector3::Zero()};
    Vector3 start_current_A{Vector3::Zero()};
};

/// The final state of a trial.
struct Ending {
    Vector3 theta_rad{Vector3::Zero()};
    Vector3 tip_m{Vector3::Zero()};
    Vector3 current_A{Vector3::Zero()};
    Vector3 hand_force_N{Vector3::Zero()}; ///< mean over the last period
};

/// The plant's equations as simulated_phantom.h states them, y = (q, q̇, i, x, ẋ, ∫ spring dt, θ,
/// θ̇). Without cables θ is not integrated.
class PlantEquations {
public:
    explicit PlantEquations(const Trial &trial)
        : device_(trial.device), options_(trial.options), command_(trial.command),
          target_m_(device::tip_position_m(device_.geometry, trial.start_q_rad)), start_(24) {
        start_ << trial.start_q_rad, trial.start_rate, trial.start_current_A, target_m_,
            device::joint_jacobian(device_.geometry, trial.start_q_rad) * trial.start_rate,
            Vector3::Zero(), device::motor_from_joint(device_.geometry, trial.start_q_rad),
            device::motor_from_joint(device_.geometry, trial.start_rate);
        // The whole compliance is 1/K; without the other side all of it is on this one.
        const double cable_share = bends() ? device_.structure.cable_share.value_or(0.5) : 1.0;
        const Matrix3 J = device::motor_jacobian(device_.geometry, device::default_pose_rad());
        for (int j = 0; j < 3; ++j) {
            const double rotor_kg_m2 =
                device_.motor[static_cast<std::size_t>(j)].rotor_inertia_kg_m2;
            cable_Nm_per_rad_[j] =
                device_.structure.stiffness_N_per_m / cable_share * J.col(j).dot(J.col(j));
            cable_Nms_per_rad_[j] = 2.0 * device_.structure.cable_damping_ratio *
                                    std::sqrt(cable_Nm_per_rad_[j] * rotor_kg_m2);
        }
        tip_side_ =
            1.0 / (1.0 - (has_cables() ? device_.structure.cable_share.value_or(0.5) : 0.0));
        // A hand's mass adds inertia, but no weight.
        inertia_ = device::linkage_moments(device_.geometry, device_.inertia,
                                           bends() ? 0.0 : options_.hand.mass_kg);
        weight_ = device::linkage_moments(device_.geometry, device_.inertia, 0.0);
    }

    [[nodiscard]] Ending integrated() const {
        const auto at = [this](int periods) {
            return testing::integrate([this](double, const VectorXd &y) { return rates(y); },
                                      start_, periods * kPeriod_s);
        };
        const VectorXd before = at(kReferencePeriods - 1);
        const VectorXd end = at(kReferencePeriods);
        const device::HandParameters &hand = options_.hand;
        const Vector3 impulse = (end - before).segment<3>(15) -
                                hand.damping_Ns_per_m * (end - before).segment<3>(9) -
                                hand.mass_kg * (end - before).segment<3>(12);
        const Vector3 theta_rad = has_cables()
                                      ? Vector3(end.segment<3>(18))
                                      : device::motor_from_joint(device_.geometry, end.head<3>());
        return {theta_rad, end.segment<3>(9), end.segment<3>(6), impulse / kPeriod_s};
    }

private:
    [[nodiscard]] bool bends() const { return options_.effects.structural_compliance; }
    [[nodiscard]] bool has_cables() const { return options_.effects.cable_compliance; }

    [[nodiscard]] VectorXd rates(const VectorXd &y) const {
        const Vector3 q = y.head<3>();
        const Vector3 w = y.segment<3>(3);
        const Vector3 tip_m = y.segment<3>(9);
        const Vector3 tip_rate = y.segment<3>(12);
        const Matrix3 J = device::joint_jacobian(device_.geometry, q);
        const Vector3 spring_N = options_.hand.stiffness_N_per_m * (target_m_ - tip_m);
        const Vector3 pull_N = spring_N - options_.hand.damping_Ns_per_m * tip_rate;
        Vector3 on_linkage_N = pull_N;
        if (bends()) {
            on_linkage_N = tip_side_ * (device_.structure.stiffness_N_per_m *
                                            (tip_m - device::tip_position_m(device_.geometry, q)) +
                                        device_.structure.damping_Ns_per_m * (tip_rate - J * w));
        }
        const Vector3 theta_rad = has_cables() ? Vector3(y.segment<3>(18))
                                               : device::motor_from_joint(device_.geometry, q);
        const Vector3 theta_rate = has_cables() ? Vector3(y.segment<3>(21))
                                                : device::motor_from_joint(device_.geometry, w);
        const Vector3 motor_Nm = torque_Nm(theta_rad, y.segment<3>(6));
        Vector3 on_joints_Nm = motor_Nm;
        Vector3 theta_acceleration = Vector3::Zero();
        if (has_cables()) {
            on_joints_Nm = cable_Nm_per_rad_.cwiseProduct(
                               theta_rad - device::motor_from_joint(device_.geometry, q)) +
                           cable_Nms_per_rad_.cwiseProduct(
                               theta_rate - device::motor_from_joint(device_.geometry, w));
            for (int j = 0; j < 3; ++j) {
                theta_acceleration[j] =
                    (motor_Nm[j] - on_joints_Nm[j]) /
                    device_.motor[static_cast<std::size_t>(j)].rotor_inertia_kg_m2;
            }
        }
        const Vector3 q_acceleration =
            acceleration(q, w,
                         J.transpose() * on_linkage_N +
                             device::motor_from_joint(device_.geometry, on_joints_Nm));
        const Vector3 tip_acceleration =
            bends() ? Vector3((pull_N - on_linkage_N) / options_.hand.mass_kg)
                    : Vector3(J * q_acceleration +
                              device::joint_jacobian_rate(device_.geometry, q, w) * w);
        VectorXd y_rate(24);
        y_rate << w, q_acceleration, current_rate(theta_rad, theta_rate, y.segment<3>(6)), tip_rate,
            tip_acceleration, spring_N, has_cables() ? theta_rate : Vector3(Vector3::Zero()),
            theta_acceleration;
        return y_rate;
    }

    [[nodiscard]] Vector3 acceleration(const Vector3 &q, const Vector3 &w,
                                       const Vector3 &load_Nm) const {
        Matrix3 M = device::mass_matrix(inertia_, q);
        Vector3 torque_Nm = load_Nm - device::coriolis_torque_Nm(inertia_, q, w) -
                            device::gravity_torque_Nm(weight_, q) -
                            device_.friction.viscous_Nms_per_rad * w;
        for (int j = 0; j < 3 && !has_cables(); ++j) {
            const double N = device_.geometry.transmission_ratio[j];
            M(j, j) += N * N * device_.motor[static_cast<std::size_t>(j)].rotor_inertia_kg_m2;
        }
        return M.inverse() * torque_Nm;
    }

    /// Of the motors, on their shafts.
    [[nodiscard]] Vector3 torque_Nm(const Vector3 &theta_rad, const Vector3 &current_A) const {
        return {torque_constant(0, theta_rad[0]) * current_A[0],
                torque_constant(1, theta_rad[1]) * current_A[1],
                torque_constant(2, theta_rad[2]) * current_A[2]};
    }

    [[nodiscard]] double torque_constant(int j, double theta_rad) const {
        const device::MotorParameters &motor = device_.motor[static_cast<std::size_t>(j)];
        const SampledMotor &own = own_.motor[static_cast<std::size_t>(j)];
        const double turned_rad = own.ripples_per_segment * motor.commutator_segments * theta_rad;
        return own.torque_constant_share * motor.torque_constant_Nm_per_A *
               (1.0 + own.torque_ripple * std::cos(turned_rad + own.torque_ripple_phase_rad));
    }

    [[nodiscard]] Vector3 current_rate(const Vector3 &theta_rad, const Vector3 &theta_rate,
                                       const Vector3 &current_A) const {
        if (options_.amplifier == device::AmplifierKind::current_drive) {
            return Vector3::Zero(); // holds the 0 A that it starts with
        }
        Vector3 rate;
        for (int j = 0; j < 3; ++j) {
            const device::MotorParameters &motor = device_.motor[static_cast<std::size_t>(j)];
            const SampledMotor &own = own_.motor[static_cast<std::size_t>(j)];
            const double turned_rad =
                own.ripples_per_segment * motor.commutator_segments * theta_rad[j];
            const double second = own.second_harmonic_ratio;
            const double ripple =
                motor.commutation_ripple / (1.0 + second) *
                (std::cos(turned_rad + own.commutator_phase_rad) +
                 second * std::cos(2.0 * turned_rad + own.second_harmonic_phase_rad));
            const double R_Ohm = own.resistance_share * motor.resistance_Ohm * (1.0 + ripple);
            rate[j] =
                (command_.e_W_V[j] - (R_Ohm - command_.cancelled_resistance_Ohm[j]) * current_A[j] -
                 options_.brush_voltage_V.value_or(0.0) *
                     std::tanh(current_A[j] / options_.brush_current_A) -
                 torque_constant(j, theta_rad[j]) * theta_rate[j]) /
                motor.inductance_H;
        }
        return rate;
    }

    device::DeviceDescription device_;
    SimulationOptions options_;
    SampledDevice own_ = sampled_device(device_, options_.device_seed);
    device::DeviceCommand command_;
    Vector3 target_m_;
    Vector3 cable_Nm_per_rad_{Vector3::Zero()};
    Vector3 cable_Nms_per_rad_{Vector3::Zero()};
    double tip_side_ = 1.0; ///< its stiffness and damping, relative to the whole structure's
    VectorXd start_;
    device::LinkageMoments inertia_;
    device::LinkageMoments weight_;
};

Ending simulated(const Trial &trial, double step_s) {
    SimulationOptions options = trial.options;
    options.longest_step_s = step_s;
    SimulatedPhantom plant(trial.device, options,
                           device::tip_position_m(trial.device.geometry, trial.start_q_rad));
    plant.set_in_motion(trial.start_rate, trial.start_current_A);
    for (int k = 0; k < kReferencePeriods; ++k) {
        plant.advance(trial.command);
    }
    const SimulatedPhantom::Truth &t = plant.truth();
    return {t.theta_rad, t.tip_m, t.current_A, t.hand_force_N};
}

/// Parameters of a trial.
struct Plant {
    device::AmplifierKind amplifier = device::AmplifierKind::spring_drive;
    bool bends = false;
    bool is_sampled = false; ///< with brushes and ripples of its own
    bool has_cables = false;

    [[nodiscard]] std::string name() const {
        return std::string(amplifier == device::AmplifierKind::spring_drive ? "SpringDrive"
                                                                            : "CurrentDrive") +
               (bends ? "Compliant" : "Rigid") + (is_sampled ? "Sampled" : "") +
               (has_cables ? "Cables" : "");
    }
};
void PrintTo(const Plant &plant, std::ostream *out) { *out << plant.name(); }

Trial random_trial(const Plant &plant, std::mt19937_64 &random) {
    Trial trial;
    trial.options.effects = PlantEffects::none();
    trial.options.effects.gravity = true;
    trial.options.effects.viscous_friction = true;
    trial.options.effects.commutation_ripple = true;
    trial.options.effects.structural_compliance = plant.bends;
    trial.options.effects.cable_compliance = plant.has_cables;
    trial.device.structure.cable_share = 0.6;
    trial.options.amplifier = plant.amplifier;
    trial.options.servo_period_s = kPeriod_s;
    trial.options.hand.max_force_N = 1e6; // a limit has a corner
    trial.start_q_rad = testing::random_workspace_angles(trial.device, random);
    trial.start_rate = testing::random_vector(random, 2.0);
    if (plant.is_sampled) {
        trial.options.effects.motor_tolerances = true;
        trial.options.effects.commutator_phase = true;
        trial.options.effects.torque_ripple = true;
        trial.options.device_seed = 1 + random() % 1000;
        trial.options.brush_voltage_V = 0.1;
        trial.options.brush_current_A = 0.1;
    }
    if (plant.amplifier == device::AmplifierKind::spring_drive) { // a current drive stays at 0 A
        trial.start_current_A = testing::random_vector(random, 0.5);
        trial.command.e_W_V = testing::random_vector(random, 0.3);
        trial.command.cancelled_resistance_Ohm.setConstant(1.6);
    }
    return trial;
}

class PlantReference : public ::testing::TestWithParam<Plant> {};

TEST_P(PlantReference, ConvergesAtSecondOrderFarBelowAnEncoderCount) {
    std::mt19937_64 random(71);
    for (int run = 0; run < 6; ++run) {
        const Trial trial = random_trial(GetParam(), random);
        const Ending truth = PlantEquations(trial).integrated();
        // Ripples of up to 44 periods a turn are as accurate at a quarter of the step.
        const double step_s = (GetParam().is_sampled ? 0.25 : 1.0) * kStep_s;
        const Ending usual = simulated(trial, step_s);
        const Ending fine = simulated(trial, 0.5 * step_s);
        const auto order = [](const Vector3 &of_truth, const Vector3 &of_usual,
                              const Vector3 &of_fine) {
            return std::log2((of_usual - of_truth).norm() / (of_fine - of_truth).norm());
        };
        EXPECT_NEAR(order(truth.theta_rad, usual.theta_rad, fine.theta_rad), 2.0, 0.15);
        EXPECT_NEAR(order(truth.tip_m, usual.tip_m, fine.tip_m), 2.0, 0.15);
        EXPECT_NEAR(order(truth.hand_force_N, usual.hand_force_N, fine.hand_force_N), 2.0, 0.15);

        // After 50 ms: a count is 1.5e-3 rad, the device resolves 30 µm, and no finger 1 mN.
        EXPECT_LT((usual.theta_rad - truth.theta_rad).norm(), 5e-6);
        EXPECT_LT((usual.tip_m - truth.tip_m).norm(), 3e-8);
        EXPECT_LT((usual.hand_force_N - truth.hand_force_N).norm(), 3e-4);
        EXPECT_LT((usual.current_A - truth.current_A).norm(), 5e-5);
        if (GetParam().amplifier == device::AmplifierKind::spring_drive) {
            EXPECT_NEAR(order(truth.current_A, usual.current_A, fine.current_A), 2.0, 0.15);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    Plants, PlantReference,
    ::testing::Values(Plant{device::AmplifierKind::spring_drive, false},
                      Plant{device::AmplifierKind::spring_drive, true},
                      Plant{device::AmplifierKind::spring_drive, false, true},
                      Plant{device::AmplifierKind::spring_drive, true, true},
                      Plant{device::AmplifierKind::current_drive, false},
                      Plant{device::AmplifierKind::current_drive, true},
                      Plant{device::AmplifierKind::spring_drive, false, false, true},
                      Plant{device::AmplifierKind::spring_drive, true, false, true},
                      Plant{device::AmplifierKind::spring_drive, true, true, true},
                      Plant{device::AmplifierKind::current_drive, true, false, true}),
    [](const auto &instance) { return instance.param.name(); });

// Covers device/simulated/simulated_phantom.cpp, linkage_step.cpp and simulated_phantom.h: without
// a source the plant never gains energy, and friction holds loads below breakaway.

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
        options.device_seed = run % 7 == 0 ? static_cast<std::uint64_t>(run) : 0;
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
    for (const double rate_rad_per_s : {3.0, 300.0}) {
        const LinkageState before{Vector3(0.1, 0.2, 0.1),
                                  rate_rad_per_s * Vector3(0.6, 0.64, -0.48)};
        std::array<FrictionMode, 3> modes{};
        const LinkageMotion motion = linkage_step(plant, before, {}, kPeriod_s, modes);
        EXPECT_GT(motion.after.rate_rad_per_s.norm(), 0.1 * rate_rad_per_s);
        const Vector3 way_m = device::tip_position_m(plant.geometry, motion.after.q_rad) -
                              device::tip_position_m(plant.geometry, before.q_rad);
        EXPECT_LT((kPeriod_s * motion.mean_tip_velocity_m_per_s - way_m).norm(), 1e-12);
        const Vector3 turned_rad = motion.after.q_rad - before.q_rad;
        EXPECT_LT((kPeriod_s * motion.mean_rate_rad_per_s - turned_rad).norm(), 1e-12);
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
