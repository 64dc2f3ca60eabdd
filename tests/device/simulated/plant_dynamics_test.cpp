// Covers the reduced plants of device/simulated/simulated_phantom.cpp, linkage_step.cpp and
// plant_setup.cpp: without inductance, masses or base joint.
#include "device/simulated/simulated_phantom.h"

#include "base/input_error.h"
#include "device/core/phantom/kinematics.h"
#include "device/simulated/simulation_options.h"
#include "tests/support/configurations.h"
#include "tests/support/cvode.h"
#include "tests/support/devices.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <ostream>
#include <random>
#include <string>

namespace springdrive::simulated {
namespace {

using Eigen::VectorXd;

constexpr int kPeriods = 40;
constexpr double kEnd_s = 0.04;
constexpr double kCancelled_Ohm = 1.6;

/// Links, rotors, windings and hand, without limits.
SimulationOptions bare(PlantDynamics dynamics) {
    SimulationOptions options;
    options.dynamics = dynamics;
    options.effects = PlantEffects::none();
    options.hand.max_force_N = 1e6; // a limit has a corner
    return options;
}

device::DeviceCommand voltage(const Vector3 &e_W_V) {
    return {e_W_V, Vector3::Constant(kCancelled_Ohm)};
}

/// The tip's displacement from its start, under a constant command.
template <typename Command>
Vector3 moved_m(const device::DeviceDescription &device, const SimulationOptions &options,
                const Command &command, int periods = kPeriods) {
    SimulatedPhantom plant(device, options, testing::kOffCentre_m);
    for (int k = 0; k < periods; ++k) {
        plant.advance(command);
    }
    return plant.truth().tip_m - testing::kOffCentre_m;
}

// Closed forms: motions so small that the plant is linear, about the vertical axis alone.

constexpr double kSmall = 1e-6;

/// Parameters of the base joint at the start, in joint coordinates.
struct BaseJoint {
    device::DeviceDescription device = testing::phantom_1_0();
    Vector3 q_rad = *device::joint_angles_rad(device.geometry, testing::kOffCentre_m);
    double N = device.geometry.transmission_ratio[0];
    double k_T = device.motor[0].torque_constant_Nm_per_A;
    double dR_Ohm = device.motor[0].resistance_Ohm - kCancelled_Ohm;
    double reach_m = device::joint_jacobian(device.geometry, q_rad).col(0).norm();
    double drive_Nms_per_rad = N * N * k_T * k_T / dR_Ohm;

    [[nodiscard]] double inertia_kg_m2(double hand_kg) const {
        return device::mass_matrix(
                   device::linkage_moments(device.geometry, device.inertia, hand_kg), q_rad)(0, 0) +
               N * N * device.motor[0].rotor_inertia_kg_m2;
    }
};

TEST(RigidBody, AcceleratesLikeARotorBehindADamper) {
    // (11) without L: M q̈ = N k_T (e_W − k_T N q̇)/dR, so q̇ = e_W/(N k_T) (1 − e^(−t/τ)).
    const BaseJoint base;
    SimulationOptions options = bare(PlantDynamics::rigid_body);
    options.hand = {0.1, 0.0, 0.0, 0.0, 1.0};
    SimulatedPhantom plant(base.device, options, testing::kOffCentre_m);
    const double tau_s = base.inertia_kg_m2(options.hand.mass_kg) / base.drive_Nms_per_rad;
    const device::DeviceCommand command = voltage(Vector3(kSmall, 0.0, 0.0));
    for (int k = 1; k <= kPeriods; ++k) {
        const device::Measurement state = plant.advance(command);
        const double rate = kSmall / base.k_T * (1.0 - std::exp(-1e-3 * k / tau_s));
        // Second order: a relative error of (h/τ)²/12 = 5e-6, with τ = 13 ms.
        ASSERT_NEAR(plant.truth().theta_rate_rad_per_s[0], rate, 1e-5 * kSmall / base.k_T);
        ASSERT_NEAR(state.current_A[0], (kSmall - base.k_T * rate) / base.dR_Ohm,
                    1e-5 * kSmall / base.dR_Ohm);
    }
}

TEST(Coupling, RelaxesExponentiallyTowardsTheHand) {
    // No mass: drive and hand's damper against the hand's spring, τ = (B + b r²)/(k r²).
    const BaseJoint base;
    SimulationOptions options = bare(PlantDynamics::coupling);
    const Vector3 sideways =
        device::joint_jacobian(base.device.geometry, base.q_rad).col(0).normalized();
    options.path = HandPath({{0.0, testing::kOffCentre_m + kSmall * sideways}});
    SimulatedPhantom plant(base.device, options, testing::kOffCentre_m);
    const double r_squared = base.reach_m * base.reach_m;
    const double tau_s = (base.drive_Nms_per_rad + options.hand.damping_Ns_per_m * r_squared) /
                         (options.hand.stiffness_N_per_m * r_squared);
    double before_m = 0.0;
    for (int k = 1; k <= kPeriods; ++k) {
        plant.advance(voltage(Vector3::Zero()));
        const double way_m = (plant.truth().tip_m - testing::kOffCentre_m).dot(sideways);
        ASSERT_NEAR(way_m, kSmall * (1.0 - std::exp(-1e-3 * k / tau_s)), 1e-5 * kSmall);
        // The hand's force equals that of the drive.
        ASSERT_NEAR(plant.truth().hand_force_N.dot(sideways),
                    base.drive_Nms_per_rad * (way_m - before_m) / 1e-3 / r_squared, 1e-12);
        before_m = way_m;
    }
}

TEST(Coupling, WithACurrentDriveOnlyTheHandHoldsTheTip) {
    SimulationOptions options = bare(PlantDynamics::coupling);
    options.amplifier = device::AmplifierKind::current_drive;
    const BaseJoint base;
    PlantCommand command;
    command.current_A[0] = kSmall;
    // At rest k x = J⁻ᵀ N k_T i, after ten time constants b/k of 20 ms.
    const Vector3 end_m = moved_m(base.device, options, command, 400);
    const Matrix3 J = device::joint_jacobian(base.device.geometry, base.q_rad);
    const Vector3 force_N = J.transpose().inverse() * Vector3(base.N * base.k_T * kSmall, 0.0, 0.0);
    EXPECT_LT((end_m - force_N / options.hand.stiffness_N_per_m).norm(), 1e-6 * end_m.norm());
}

// All effects together, compared with CVODE.

struct Case {
    PlantDynamics dynamics = PlantDynamics::rigid_body;
    bool planar = false;

    [[nodiscard]] std::string name() const {
        return std::string(dynamics == PlantDynamics::coupling     ? "Coupling"
                           : dynamics == PlantDynamics::rigid_body ? "RigidBody"
                                                                   : "Electromechanical") +
               (planar ? "Planar" : "");
    }
};
void PrintTo(const Case &plant, std::ostream *out) { *out << plant.name(); }

/// The equations of simulated_phantom.h without the omitted parts, y = (q, q̇, i).
class Equations {
public:
    Equations(const device::DeviceDescription &device, const SimulationOptions &options,
              const Vector3 &start_m, const device::DeviceCommand &command)
        : device_(device), options_(options), command_(command), target_m_(start_m),
          inertia_(device::linkage_moments(device.geometry, device.inertia, options.hand.mass_kg)),
          weight_(device::linkage_moments(device.geometry, device.inertia, 0.0)) {}

    [[nodiscard]] Vector3 tip_at_end_m(const Vector3 &start_q_rad,
                                       const Vector3 &start_rate) const {
        VectorXd start(9);
        start << start_q_rad, start_rate, Vector3::Zero();
        const VectorXd end = testing::integrate(
            [this](double, const VectorXd &y) { return rates(y); }, start, kEnd_s);
        return device::tip_position_m(device_.geometry, end.head<3>());
    }

private:
    [[nodiscard]] VectorXd rates(const VectorXd &y) const {
        const Vector3 q = y.head<3>();
        VectorXd y_rate = VectorXd::Zero(9);
        if (options_.dynamics == PlantDynamics::coupling) {
            // Without masses: damping · q̇ = the terms independent of q̇.
            Matrix3 damping = Matrix3::Zero();
            for (int column = 0; column < 3; ++column) {
                damping.col(column) =
                    torque(q, Vector3::Zero(), at_once_A(Vector3::Zero())) -
                    torque(q, Vector3::Unit(column), at_once_A(Vector3::Unit(column)));
            }
            y_rate.head<3>() =
                solved(damping, torque(q, Vector3::Zero(), at_once_A(Vector3::Zero())));
            return y_rate;
        }
        const Vector3 w = y.segment<3>(3);
        const bool winds = options_.dynamics == PlantDynamics::electromechanical;
        const Vector3 current_A = winds ? Vector3(y.tail<3>()) : at_once_A(w);
        Matrix3 M = device::mass_matrix(inertia_, q);
        for (int j = 0; j < 3; ++j) {
            const double N = device_.geometry.transmission_ratio[j];
            M(j, j) += N * N * device_.motor[static_cast<std::size_t>(j)].rotor_inertia_kg_m2;
        }
        y_rate.head<3>() = w;
        y_rate.segment<3>(3) =
            solved(M, torque(q, w, current_A) - device::coriolis_torque_Nm(inertia_, q, w));
        if (winds) {
            y_rate.tail<3>() =
                (at_once_A(w) - current_A) * dR_Ohm() / device_.motor[0].inductance_H;
        }
        return y_rate;
    }

    [[nodiscard]] double dR_Ohm() const {
        return device_.motor[0].resistance_Ohm - command_.cancelled_resistance_Ohm[0];
    }
    [[nodiscard]] Vector3 at_once_A(const Vector3 &w) const {
        return (command_.e_W_V - device_.motor[0].torque_constant_Nm_per_A *
                                     device::motor_from_joint(device_.geometry, w)) /
               dR_Ohm();
    }
    [[nodiscard]] Vector3 torque(const Vector3 &q, const Vector3 &w,
                                 const Vector3 &current_A) const {
        const Matrix3 J = device::joint_jacobian(device_.geometry, q);
        const device::HandParameters &hand = options_.hand;
        const Vector3 tip_N =
            hand.stiffness_N_per_m * (target_m_ - device::tip_position_m(device_.geometry, q)) -
            hand.damping_Ns_per_m * (J * w);
        return J.transpose() * tip_N - device::gravity_torque_Nm(weight_, q) -
               device_.friction.viscous_Nms_per_rad * w +
               device_.motor[0].torque_constant_Nm_per_A *
                   device::motor_from_joint(device_.geometry, current_A);
    }
    /// In a plane, the base joint does not move.
    [[nodiscard]] Vector3 solved(const Matrix3 &A, const Vector3 &b) const {
        if (!options_.planar) {
            return A.inverse() * b;
        }
        Vector3 x = Vector3::Zero();
        x.tail<2>() = A.bottomRightCorner<2, 2>().inverse() * b.tail<2>();
        return x;
    }

    device::DeviceDescription device_;
    SimulationOptions options_;
    device::DeviceCommand command_;
    Vector3 target_m_;
    device::LinkageMoments inertia_;
    device::LinkageMoments weight_;
};

class ReducedPlant : public ::testing::TestWithParam<Case> {};

TEST_P(ReducedPlant, ConvergesAtSecondOrder) {
    const device::DeviceDescription device = testing::phantom_1_0();
    std::mt19937_64 random(81);
    for (int run = 0; run < 6; ++run) {
        SimulationOptions options = bare(GetParam().dynamics);
        options.planar = GetParam().planar;
        options.effects.gravity = true;
        options.effects.viscous_friction = true;
        const Vector3 start_q_rad = testing::random_workspace_angles(device, random);
        const Vector3 start_m = device::tip_position_m(device.geometry, start_q_rad);
        Vector3 start_rate = testing::random_vector(random, 1.0);
        if (options.planar) {
            start_rate[0] = 0.0;
        }
        const device::DeviceCommand command = voltage(testing::random_vector(random, 0.3));

        const Vector3 truth_m =
            Equations(device, options, start_m, command).tip_at_end_m(start_q_rad, start_rate);
        const auto error_m = [&](double step_s) {
            options.longest_step_s = step_s;
            SimulatedPhantom plant(device, options, start_m);
            plant.set_in_motion(start_rate, Vector3::Zero());
            for (int k = 0; k < kPeriods; ++k) {
                plant.advance(command);
            }
            return (plant.truth().tip_m - truth_m).norm();
        };
        const double usual_m = error_m(100e-6);
        const double fine_m = error_m(50e-6);
        EXPECT_NEAR(std::log2(usual_m / fine_m), 2.0, 0.1) << "run " << run;
        EXPECT_LT(usual_m, 3e-8); // 30 µm is what the device resolves
    }
}

INSTANTIATE_TEST_SUITE_P(Plants, ReducedPlant,
                         ::testing::Values(Case{PlantDynamics::rigid_body, false},
                                           Case{PlantDynamics::rigid_body, true},
                                           Case{PlantDynamics::coupling, false},
                                           Case{PlantDynamics::coupling, true},
                                           Case{PlantDynamics::electromechanical, true}),
                         [](const auto &instance) { return instance.param.name(); });

// Convergence as the omitted quantities become small.

/// The order of convergence of the fuller plant to the reduced one as the omitted quantity is
/// halved.
template <typename Fuller> double order(const Vector3 &reduced_m, const Fuller &fuller_m) {
    return std::log2((fuller_m(1.0 / 16.0) - reduced_m).norm() /
                     (fuller_m(1.0 / 32.0) - reduced_m).norm());
}

TEST(RigidBody, IsTheLimitOfSmallInductance) {
    const device::DeviceCommand command = voltage(Vector3(0.1, -0.2, 0.15));
    SimulationOptions options = bare(PlantDynamics::rigid_body);
    options.longest_step_s = 10e-6;
    const Vector3 reduced_m = moved_m(testing::phantom_1_0(), options, command);
    options.dynamics = PlantDynamics::electromechanical;
    const double found = order(reduced_m, [&](double share) {
        device::DeviceDescription device = testing::phantom_1_0();
        for (device::MotorParameters &motor : device.motor) {
            motor.inductance_H *= share;
        }
        return moved_m(device, options, command);
    });
    EXPECT_NEAR(found, 1.0, 0.1);
}

TEST(Coupling, IsTheLimitOfSmallMasses) {
    const device::DeviceCommand command = voltage(Vector3(0.1, -0.2, 0.15));
    SimulationOptions options = bare(PlantDynamics::coupling);
    options.longest_step_s = 10e-6;
    const Vector3 reduced_m = moved_m(testing::phantom_1_0(), options, command);
    options.dynamics = PlantDynamics::rigid_body;
    const double found = order(reduced_m, [&](double share) {
        device::DeviceDescription device = testing::phantom_1_0();
        for (device::LinkBody *body : {&device.inertia.upper_arm, &device.inertia.crank,
                                       &device.inertia.rod, &device.inertia.forearm}) {
            body->mass_kg *= share;
            body->inertia_kg_m2 *= share;
        }
        device.inertia.base_kg_m2 *= share;
        for (device::MotorParameters &motor : device.motor) {
            motor.rotor_inertia_kg_m2 *= share;
        }
        SimulationOptions light = options;
        light.hand.mass_kg *= share;
        return moved_m(device, light, command);
    });
    EXPECT_NEAR(found, 1.0, 0.1);
}

// The plane.

TEST(Planar, EqualsTheWholeDeviceWithoutLateralForces) {
    const device::DeviceDescription device = testing::phantom_1_0();
    std::mt19937_64 random(82);
    for (const PlantModel &model : kPlantModels) {
        for (int run = 0; run < 4; ++run) {
            const Vector3 q_rad = testing::random_workspace_angles(device, random);
            Vector3 to_q_rad = q_rad;
            to_q_rad.tail<2>() += testing::random_vector(random, 0.1).tail<2>();
            if (!device.joint_limits.allow(q_rad)) {
                continue;
            }
            SimulationOptions options;
            options.dynamics = model.dynamics;
            options.effects = model.effects;
            options.path = HandPath({{0.0, device::tip_position_m(device.geometry, to_q_rad)}});
            const Vector3 start_m = device::tip_position_m(device.geometry, q_rad);
            SimulatedPhantom whole(device, options, start_m);
            options.planar = true;
            SimulatedPhantom planar(device, options, start_m);
            Vector3 e_W_V = testing::random_vector(random, 1.0);
            e_W_V[0] = 0.0;
            for (int k = 0; k < kPeriods; ++k) {
                whole.advance(voltage(e_W_V));
                planar.advance(voltage(e_W_V));
                const SimulatedPhantom::Truth &a = whole.truth();
                const SimulatedPhantom::Truth &b = planar.truth();
                // 400 sub-steps, each with round-off in angles and currents of about 1.
                constexpr double kRoundOff = 1e-12;
                ASSERT_LT((a.theta_rad - b.theta_rad).norm(), kRoundOff) << model.name;
                ASSERT_LT((a.tip_m - b.tip_m).norm(), kRoundOff) << model.name;
                ASSERT_LT((a.current_A - b.current_A).norm(), 100.0 * kRoundOff) << model.name;
                ASSERT_LT((a.hand_force_N - b.hand_force_N).norm(), 1e-9) << model.name;
            }
            EXPECT_GT((planar.truth().tip_m - start_m).norm(), 1e-4) << model.name; // it moved
        }
    }
}

TEST(Planar, TheBaseStaysAtRestUnderAnyForce) {
    for (const PlantModel &model : kPlantModels) {
        SimulationOptions options;
        options.dynamics = model.dynamics;
        options.effects = model.effects;
        options.planar = true;
        SimulatedPhantom plant(testing::phantom_1_0(), options, testing::kOffCentre_m);
        plant.set_in_motion(Vector3(1.0, 0.0, 0.0), Vector3(1.0, 0.0, 0.0));
        plant.set_hand_target(testing::kOffCentre_m + Vector3(0.05, 0.0, 0.0));
        const double start_rad = plant.truth().theta_rad[0];
        const device::Measurement first = plant.advance(voltage(Vector3(1.0, 0.0, 0.0)));
        for (int k = 0; k < kPeriods; ++k) {
            const device::Measurement state = plant.advance(voltage(Vector3(1.0, 0.0, 0.0)));
            ASSERT_EQ(state.counts[0], first.counts[0]);
            ASSERT_EQ(state.current_A[0], 0.0);
            ASSERT_EQ(plant.truth().theta_rad[0], start_rad);
            ASSERT_EQ(plant.truth().theta_rate_rad_per_s[0], 0.0);
            ASSERT_TRUE(plant.truth().hand_force_N.allFinite());
        }
    }
}

// Properties of all reduced plants.

TEST(ReducedPlants, NeverGainEnergyUnderShortedWindings) {
    const device::DeviceDescription device = testing::phantom_1_0();
    std::mt19937_64 random(83);
    for (int run = 0; run < 40; ++run) {
        SimulationOptions options;
        options.dynamics = run % 2 == 0 ? PlantDynamics::rigid_body : PlantDynamics::coupling;
        options.planar = run % 4 < 2;
        options.hand = {0.05, 0.0, 0.0, 0.0, 1.0};
        options.effects.coulomb_friction = run % 8 == 0;
        options.effects.winding_heat = run % 3 == 0;
        options.servo_period_s = 0.01;
        options.longest_step_s = 1e-3; // ten times the default: the claim holds for any step
        const Vector3 start_m = device.workspace.centre_m + testing::random_vector(random, 0.02);
        SimulatedPhantom plant(device, options, start_m);
        plant.set_in_motion(testing::random_vector(random, 6.0), Vector3::Zero());
        double before_J = plant.stored_energy_J();
        const double scale_J = std::abs(before_J) + 0.1;
        for (int k = 0; k < 100; ++k) {
            plant.advance(device::DeviceCommand::braking());
            const double now_J = plant.stored_energy_J();
            // 10 sub-steps of some tens of operations each, every one of round-off ε.
            ASSERT_LE(now_J - before_J, 10 * 50 * std::numeric_limits<double>::epsilon() * scale_J)
                << "run " << run << " period " << k;
            before_J = now_J;
        }
    }
}

TEST(ReducedPlants, AreStableForAnyStepAndHand) {
    // Steps as long as the servo's period, and hands from none to a very stiff one.
    for (const PlantModel &model : kPlantModels) {
        for (const device::HandParameters &hand :
             {device::HandParameters{0.01, 0.0, 0.0, 0.0, 1.0},
              device::HandParameters{0.2, 1e3, 1e6, 1e6, 10.0}}) {
            SimulationOptions options;
            options.dynamics = model.dynamics;
            options.effects = model.effects;
            options.hand = hand;
            options.longest_step_s = 1e-3;
            SimulatedPhantom plant(testing::phantom_1_0(), options, testing::kOffCentre_m);
            plant.set_hand_target(testing::kOffCentre_m + Vector3(0.01, 0.01, -0.01));
            for (int k = 0; k < 300; ++k) {
                plant.advance(voltage(Vector3(0.05, -0.05, 0.05)));
                ASSERT_TRUE(plant.truth().tip_m.allFinite()) << model.name;
                ASSERT_LT((plant.truth().tip_m - testing::kOffCentre_m).norm(), 0.5) << model.name;
            }
        }
    }
}

TEST(ReducedPlants, RejectIncompatibleOptions) {
    const device::DeviceDescription device = testing::phantom_1_0();
    SimulationOptions options = bare(PlantDynamics::coupling);
    EXPECT_NO_THROW(SimulatedPhantom(device, options, testing::kOffCentre_m));
    options.effects.coulomb_friction = true;
    EXPECT_THROW(SimulatedPhantom(device, options, testing::kOffCentre_m), InputError);
    options.effects.coulomb_friction = false;
    options.effects.structural_compliance = true;
    EXPECT_THROW(SimulatedPhantom(device, options, testing::kOffCentre_m), InputError);
    options.effects.structural_compliance = false;
    options.hand = {0.0, 0.0, 0.0, 0.0, 1.0};
    EXPECT_NO_THROW(
        SimulatedPhantom(device, options, testing::kOffCentre_m)); // a spring drive holds the tip
    options.amplifier = device::AmplifierKind::current_drive;
    EXPECT_THROW(SimulatedPhantom(device, options, testing::kOffCentre_m), InputError);
    options.hand.damping_Ns_per_m = 1.0;
    EXPECT_NO_THROW(SimulatedPhantom(device, options, testing::kOffCentre_m));
}

} // namespace
} // namespace springdrive::simulated
