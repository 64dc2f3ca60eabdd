// Covers device/simulated/simulated_phantom.cpp against CVODE.
#include "device/simulated/simulated_phantom.h"

#include "device/core/phantom/kinematics.h"
#include "tests/support/configurations.h"
#include "tests/support/cvode.h"
#include "tests/support/devices.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <random>
#include <string>

namespace springdrive::simulated {
namespace {

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

/// The plant's equations as simulated_phantom.h states them, y = (q, q̇, i, x, ẋ, ∫ spring dt).
class PlantEquations {
public:
    explicit PlantEquations(const Trial &trial)
        : device_(trial.device), options_(trial.options), command_(trial.command),
          target_m_(device::tip_position_m(device_.geometry, trial.start_q_rad)), start_(18) {
        start_ << trial.start_q_rad, trial.start_rate, trial.start_current_A, target_m_,
            device::joint_jacobian(device_.geometry, trial.start_q_rad) * trial.start_rate,
            Vector3::Zero();
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
        const Vector3 impulse = end.tail<3>() - before.tail<3>() -
                                hand.damping_Ns_per_m * (end - before).segment<3>(9) -
                                hand.mass_kg * (end - before).segment<3>(12);
        return {device::motor_from_joint(device_.geometry, end.head<3>()), end.segment<3>(9),
                end.segment<3>(6), impulse / kPeriod_s};
    }

private:
    [[nodiscard]] bool bends() const { return options_.effects.structural_compliance; }

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
            on_linkage_N = device_.structure.stiffness_N_per_m *
                               (tip_m - device::tip_position_m(device_.geometry, q)) +
                           device_.structure.damping_Ns_per_m * (tip_rate - J * w);
        }
        const Vector3 q_acceleration =
            acceleration(q, w, y.segment<3>(6), J.transpose() * on_linkage_N);
        const Vector3 tip_acceleration =
            bends() ? Vector3((pull_N - on_linkage_N) / options_.hand.mass_kg)
                    : Vector3(J * q_acceleration +
                              device::joint_jacobian_rate(device_.geometry, q, w) * w);
        VectorXd y_rate(18);
        y_rate << w, q_acceleration, current_rate(q, w, y.segment<3>(6)), tip_rate,
            tip_acceleration, spring_N;
        return y_rate;
    }

    [[nodiscard]] Vector3 acceleration(const Vector3 &q, const Vector3 &w, const Vector3 &current_A,
                                       const Vector3 &load_Nm) const {
        Matrix3 M = device::mass_matrix(inertia_, q);
        Vector3 torque_Nm = load_Nm - device::coriolis_torque_Nm(inertia_, q, w) -
                            device::gravity_torque_Nm(weight_, q) -
                            device_.friction.viscous_Nms_per_rad * w;
        for (int j = 0; j < 3; ++j) {
            const device::MotorParameters &motor = device_.motor[static_cast<std::size_t>(j)];
            const double N = device_.geometry.transmission_ratio[j];
            M(j, j) += N * N * motor.rotor_inertia_kg_m2;
            torque_Nm[j] += N * motor.torque_constant_Nm_per_A * current_A[j];
        }
        return M.inverse() * torque_Nm;
    }

    [[nodiscard]] Vector3 current_rate(const Vector3 &q, const Vector3 &w,
                                       const Vector3 &current_A) const {
        if (options_.amplifier == device::AmplifierKind::current_drive) {
            return Vector3::Zero(); // holds the 0 A that it starts with
        }
        Vector3 rate;
        for (int j = 0; j < 3; ++j) {
            const device::MotorParameters &motor = device_.motor[static_cast<std::size_t>(j)];
            const double N = device_.geometry.transmission_ratio[j];
            const double ripple =
                options_.effects.commutation_ripple ? motor.commutation_ripple : 0.0;
            const double R_Ohm = motor.resistance_Ohm *
                                 (1.0 + ripple * std::cos(motor.commutator_segments * N * q[j]));
            rate[j] =
                (command_.e_W_V[j] - (R_Ohm - command_.cancelled_resistance_Ohm[j]) * current_A[j] -
                 motor.torque_constant_Nm_per_A * N * w[j]) /
                motor.inductance_H;
        }
        return rate;
    }

    device::DeviceDescription device_;
    SimulationOptions options_;
    device::DeviceCommand command_;
    Vector3 target_m_;
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

    [[nodiscard]] std::string name() const {
        return std::string(amplifier == device::AmplifierKind::spring_drive ? "SpringDrive"
                                                                            : "CurrentDrive") +
               (bends ? "Compliant" : "Rigid");
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
    trial.options.amplifier = plant.amplifier;
    trial.options.servo_period_s = kPeriod_s;
    trial.options.hand.max_force_N = 1e6; // a limit has a corner
    trial.start_q_rad = testing::random_workspace_angles(trial.device, random);
    trial.start_rate = testing::random_vector(random, 2.0);
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
        const Ending usual = simulated(trial, kStep_s);
        const Ending fine = simulated(trial, 0.5 * kStep_s);
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

INSTANTIATE_TEST_SUITE_P(Plants, PlantReference,
                         ::testing::Values(Plant{device::AmplifierKind::spring_drive, false},
                                           Plant{device::AmplifierKind::spring_drive, true},
                                           Plant{device::AmplifierKind::current_drive, false},
                                           Plant{device::AmplifierKind::current_drive, true}),
                         [](const auto &instance) { return instance.param.name(); });

} // namespace
} // namespace springdrive::simulated
