// Covers engine/control/haptic_law.cpp: its parts combined as in (30), (18) or (23), (10).
#include "engine/control/haptic_law.h"

#include "device/core/phantom/kinematics.h"
#include "engine/control/rendered_force.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

namespace springdrive::control {
namespace {

constexpr AlphaSources kGlobalAlpha{1234.5};
constexpr double kLag_s = 1.5e-3; ///< T (½ + d), 1 kHz and d 1

class HapticLawTest : public ::testing::Test {
protected:
    /// A random place and motion.
    Configuration any_configuration() {
        const Vector3 q_rad = testing::random_workspace_angles(device, random);
        return law.configuration(device::motor_from_joint(device.geometry, q_rad),
                                 testing::random_vector(random, 30.0));
    }

    /// A face, edge or vertex a few millimetres from the tip.
    contact::Contact any_contact(const Configuration &now, int constraints = 1) {
        contact::Contact contact;
        contact.touching = true;
        contact.x0_m = now.tip_m + testing::random_vector(random, 3e-3);
        contact.normal = (contact.x0_m - now.tip_m).normalized();
        contact.active_constraints = constraints;
        const Matrix3 face = contact.normal * contact.normal.transpose();
        const Vector3 along = contact.normal.unitOrthogonal();
        contact.tangent_projector =
            constraints == 1 ? Matrix3(Matrix3::Identity() - face)
                             : Matrix3((constraints == 2 ? 1.0 : 0.0) * along * along.transpose());
        contact.eta = std::uniform_real_distribution<double>(0.0, 1.0)(random);
        return contact;
    }

    std::mt19937_64 random{12};
    device::DeviceDescription device = testing::phantom_1_0();
    HapticLaw law{device};
    double k_T = device.motor[0].torque_constant_Nm_per_A;
};

TEST_F(HapticLawTest, TheConfigurationIsThatOfTheCounts) {
    // A turn of a motor is a turn; x is where the linkage is; J is how x moves with θ.
    EXPECT_LT(
        (law.theta_rad({4096, -2048, 1}) - 2.0 * std::numbers::pi * Vector3(1.0, -0.5, 1.0 / 4096))
            .norm(),
        1e-12);
    for (int run = 0; run < 100; ++run) {
        const Configuration now = any_configuration();
        const Vector3 q_rad = now.theta_rad.cwiseQuotient(device.geometry.transmission_ratio);
        EXPECT_EQ(now.tip_m, device::tip_position_m(device.geometry, q_rad));
        constexpr double kStep_rad = 1e-5;
        for (Eigen::Index j = 0; j < 3; ++j) {
            const Vector3 step_rad = kStep_rad * Vector3::Unit(j);
            const Vector3 ahead_m = law.configuration(now.theta_rad + step_rad, {}).tip_m;
            const Vector3 behind_m = law.configuration(now.theta_rad - step_rad, {}).tip_m;
            EXPECT_LT((now.J.col(j) - (ahead_m - behind_m) / (2.0 * kStep_rad)).norm(), 1e-10);
        }
    }
}

TEST_F(HapticLawTest, InFreeSpaceItOnlyCancelsTheBackEmf) {
    for (const MotionMap map : {MotionMap::inverse, MotionMap::transpose}) {
        for (int run = 0; run < 100; ++run) {
            const Configuration now = any_configuration();
            contact::Contact free;
            free.x0_m = now.tip_m;
            Tuning tuning;
            tuning.map = map;
            const LawOutcome found = law(now, free, tuning, kGlobalAlpha);
            EXPECT_EQ(found.eta, 1.0);
            EXPECT_LT((found.command.e_W_V - k_T * now.theta_rate_rad_per_s).norm(), 1e-9);
            // The same on a penetrable surface: η = 1 by the tuning.
            tuning.eta = 1.0;
            const LawOutcome clear = law(now, any_contact(now), tuning, kGlobalAlpha);
            EXPECT_LT((clear.command.e_W_V - k_T * now.theta_rate_rad_per_s).norm(), 1e-9);
        }
    }
}

TEST_F(HapticLawTest, AtRestTheTransposeMapMakesASphericalSpring) {
    // F = J⁻ᵀ k_T e_W/dR is (1 − η) α k_T K_P/dR towards x₀, in whichever direction that is.
    for (int run = 0; run < 500; ++run) {
        Configuration now = any_configuration();
        now.theta_rate_rad_per_s.setZero();
        const contact::Contact contact = any_contact(now, run % 3 + 1);
        Tuning tuning;
        tuning.eta = 0.25;
        const LawOutcome found = law(now, contact, tuning, kGlobalAlpha);
        const double eta = 1.0 - (1.0 - contact.eta) * 0.75;
        EXPECT_NEAR(found.eta, eta, 1e-15);
        const Vector3 force_N =
            now.J.transpose().inverse() * (k_T / tuning.dR_Ohm * found.command.e_W_V);
        const Vector3 expected_N = (1.0 - eta) * found.alpha_rad2_per_m2 * k_T *
                                   tuning.K_P_V_per_rad / tuning.dR_Ohm *
                                   (contact.x0_m - now.tip_m);
        EXPECT_LT((force_N - expected_N).norm(), 1e-9 * (1.0 + expected_N.norm()));
        EXPECT_LT((found.x_Sd_m - (eta * now.tip_m + (1.0 - eta) * contact.x0_m)).norm(), 1e-15);
    }
}

TEST_F(HapticLawTest, TheInverseMapGoesToWhereTheLinkageReachesTheSetPoint) {
    for (int run = 0; run < 500; ++run) {
        const Configuration now = any_configuration();
        const contact::Contact contact = any_contact(now);
        Tuning tuning;
        tuning.map = MotionMap::inverse;
        const LawOutcome found = law(now, contact, tuning, kGlobalAlpha);
        if (!found.inverse) {
            continue;
        }
        EXPECT_EQ(found.used.theta_Sd_rad, found.inverse->theta_Sd_rad);
        const Vector3 q_Sd_rad =
            found.used.theta_Sd_rad.cwiseQuotient(device.geometry.transmission_ratio);
        EXPECT_LT((device::tip_position_m(device.geometry, q_Sd_rad) - found.x_Sd_m).norm(), 1e-12);
        // ẋ_Sd: the part of the tip's motion that the contact allows, and η times the rest.
        const Vector3 x_rate = now.J * now.theta_rate_rad_per_s;
        const Vector3 set_rate = now.J * found.used.theta_Sd_rate_rad_per_s;
        const Vector3 n = contact.normal;
        EXPECT_NEAR(set_rate.dot(n), found.eta * x_rate.dot(n), 1e-9);
        EXPECT_LT((set_rate.cross(n) - x_rate.cross(n)).norm(), 1e-9);
    }
}

TEST_F(HapticLawTest, EWIsDriftCompensationOfTheMapInUse) {
    for (const MotionMap map : {MotionMap::inverse, MotionMap::transpose}) {
        for (int run = 0; run < 300; ++run) {
            const Configuration now = any_configuration();
            Tuning tuning;
            tuning.map = map;
            const LawOutcome found = law(now, any_contact(now), tuning, kGlobalAlpha);
            for (Eigen::Index j = 0; j < 3; ++j) {
                const double rate = now.theta_rate_rad_per_s[j];
                const double set_rate = found.used.theta_Sd_rate_rad_per_s[j];
                const double gap_rad = found.used.theta_Sd_rad[j] - now.theta_rad[j];
                const double e_W_V = k_T * set_rate + tuning.K_D_Vs_per_rad * (set_rate - rate) +
                                     tuning.K_P_V_per_rad * gap_rad; // (10)
                EXPECT_NEAR(found.command.e_W_V[j], e_W_V, 1e-12);
            }
        }
    }
}

TEST_F(HapticLawTest, TheStiffnessDoesNotDependOnTheObservedTorqueConstants) {
    // What e_W adds to the back-EMF makes the same torque k_T e_W/dR for a given motion.
    for (int run = 0; run < 300; ++run) {
        const Configuration now = any_configuration();
        const contact::Contact contact = any_contact(now);
        const Tuning tuning;
        ObservedMotors motors = motors_of_file(device.motor);
        const LawOutcome expected = law(now, contact, tuning, kGlobalAlpha, motors, kLag_s);
        const Vector3 share = Vector3::Ones() + testing::random_vector(random, 0.2);
        for (std::size_t j = 0; j < motors.size(); ++j) {
            motors[j].torque_constant_Nm_per_A *= share[static_cast<Eigen::Index>(j)];
        }
        const LawOutcome found = law(now, contact, tuning, kGlobalAlpha, motors, kLag_s);
        const Vector3 back_emf_V = k_T * found.used.theta_Sd_rate_rad_per_s;
        const Vector3 added_V = found.command.e_W_V - share.cwiseProduct(back_emf_V);
        const Vector3 expected_V = expected.command.e_W_V - back_emf_V;
        EXPECT_LT((share.cwiseProduct(added_V) - expected_V).norm(), 1e-11) << run;
        EXPECT_EQ(found.command.cancelled_resistance_Ohm,
                  expected.command.cancelled_resistance_Ohm);
    }
}

/// A motor that is driven at s times the tuning's dR: because little is known of its R, or because
/// R̂ is limited.
ObservedMotor held_up(const device::MotorParameters &file, double dR_Ohm, double s, bool by_limit) {
    ObservedMotor motor = motor_of_file(file);
    if (by_limit) {
        motor.R_hat_limit_Ohm = file.resistance_Ohm - s * dR_Ohm;
    } else {
        motor.is_observed = true;
        motor.mean.deviation_Ohm = s * dR_Ohm / kHeldUpDeviations;
    }
    return motor;
}

/// The tip force of the currents e_W/dR at rest, with R̂ as it is passed on: (19).
Vector3 static_force_N(const device::DeviceDescription &device, const Configuration &now,
                       const device::DeviceCommand &command, const ObservedMotors &motors) {
    Vector3 torque_Nm;
    for (std::size_t j = 0; j < motors.size(); ++j) {
        const auto index = static_cast<Eigen::Index>(j);
        const double R_hat_Ohm =
            std::min(command.cancelled_resistance_Ohm[index], motors[j].R_hat_limit_Ohm);
        torque_Nm[index] = device.motor[j].torque_constant_Nm_per_A * command.e_W_V[index] /
                           (device.motor[j].resistance_Ohm - R_hat_Ohm);
    }
    return now.J.transpose().inverse() * torque_Nm;
}

TEST_F(HapticLawTest, TheForcePointsAlongTheNormalWhateverDREachMotorHas) {
    double largest_unscaled_deg = 0.0;
    for (int run = 0; run < 2000; ++run) {
        Configuration now = any_configuration();
        now.theta_rate_rad_per_s.setZero();
        contact::Contact contact = any_contact(now);
        contact.eta = 0.0;
        const Tuning tuning;
        ObservedMotors motors = motors_of_file(device.motor);
        motors[static_cast<std::size_t>(run % 3)] =
            held_up(device.motor[0], tuning.dR_Ohm, 2.5, run % 2 == 0);
        motors[static_cast<std::size_t>((run + 1) % 3)] =
            held_up(device.motor[0], tuning.dR_Ohm, 1.0 + 0.001 * (run % 600), run % 4 < 2);
        const LawOutcome found = law(now, contact, tuning, kGlobalAlpha, motors, kLag_s);
        const Vector3 force_N = static_force_N(device, now, found.command, motors);
        const Vector3 expected_N = found.stiffness_share[0] * found.alpha_rad2_per_m2 * k_T *
                                   tuning.K_P_V_per_rad / tuning.dR_Ohm *
                                   (contact.x0_m - now.tip_m);
        EXPECT_LT((force_N - expected_N).norm(), 1e-9 * (1.0 + expected_N.norm()));
        EXPECT_LT(direction_error_rad(force_N, contact.normal), 1e-7);
        device::DeviceCommand same_gains = found.command;
        same_gains.e_W_V = law(now, contact, tuning, kGlobalAlpha).command.e_W_V;
        largest_unscaled_deg =
            std::max(largest_unscaled_deg,
                     180.0 / std::numbers::pi *
                         direction_error_rad(static_force_N(device, now, same_gains, motors),
                                             contact.normal));
    }
    EXPECT_GT(largest_unscaled_deg, 25.0); // with K_P as it is
}

TEST_F(HapticLawTest, BeyondTheLimitAllMotorsLoseTheSameStiffness) {
    Configuration now = any_configuration();
    const contact::Contact contact = any_contact(now);
    const Tuning tuning;
    ObservedMotors motors = motors_of_file(device.motor);
    EXPECT_EQ(law(now, contact, tuning, kGlobalAlpha, motors, kLag_s).stiffness_share,
              Vector3::Ones());
    motors[1] = held_up(device.motor[1], tuning.dR_Ohm, 2.5, true);
    const LawOutcome found = law(now, contact, tuning, kGlobalAlpha, motors, kLag_s);
    EXPECT_LT((found.dR_Ohm - Vector3(0.5, 1.25, 0.5)).norm(), 1e-12);
    // k_T, K_D, L: P = 0.0334/(0.476e-3 + 1.5e-3) V/rad; c = k_T/(k_T + 1.5 (1.5e-3 P − K_D)).
    EXPECT_LT((found.stiffness_share - Vector3::Constant(0.504)).norm(), 1e-3);
    const Vector3 expected_V =
        k_T * found.used.theta_Sd_rate_rad_per_s +
        found.stiffness_share[0] *
            Vector3(1.0, 2.5, 1.0)
                .cwiseProduct(tuning.K_P_V_per_rad * (found.used.theta_Sd_rad - now.theta_rad) +
                              tuning.K_D_Vs_per_rad *
                                  (found.used.theta_Sd_rate_rad_per_s - now.theta_rate_rad_per_s));
    EXPECT_LT((found.command.e_W_V - expected_V).norm(), 1e-12);
    // A motor that carries no force has its own, and the others all of theirs.
    motors[1].load = 0.0;
    EXPECT_EQ(law(now, contact, tuning, kGlobalAlpha, motors, kLag_s).stiffness_share,
              Vector3(1.0, found.stiffness_share[1], 1.0));
    motors[1].load = 1.0;
    // Where the lag costs less than K_D gives, nothing is lost.
    EXPECT_EQ(law(now, contact, tuning, kGlobalAlpha, motors, 0.0).stiffness_share,
              Vector3::Ones());
}

TEST_F(HapticLawTest, TheTrimIsAddedAlongTheSpringInContactAlone) {
    ObservedMotors motors = motors_of_file(device.motor);
    ObservedMotors trimmed = motors;
    for (ObservedMotor &motor : trimmed) {
        motor.trim_V = 0.05;
    }
    const Tuning tuning;
    for (int run = 0; run < 200; ++run) {
        const Configuration now = any_configuration();
        contact::Contact free;
        free.x0_m = now.tip_m;
        EXPECT_EQ(law(now, free, tuning, kGlobalAlpha, trimmed, kLag_s).command.e_W_V,
                  law(now, free, tuning, kGlobalAlpha, motors, kLag_s).command.e_W_V);
        const contact::Contact contact = any_contact(now);
        const LawOutcome found = law(now, contact, tuning, kGlobalAlpha, trimmed, kLag_s);
        const LawOutcome without = law(now, contact, tuning, kGlobalAlpha, motors, kLag_s);
        EXPECT_EQ(found.command.cancelled_resistance_Ohm, without.command.cancelled_resistance_Ohm);
        const Vector3 current_A =
            tuning.K_P_V_per_rad / tuning.dR_Ohm * (found.used.theta_Sd_rad - now.theta_rad);
        for (Eigen::Index j = 0; j < 3; ++j) {
            const double limit_V = 3.0 * device.motor[0].resistance_Ohm * std::abs(current_A[j]);
            EXPECT_NEAR(found.command.e_W_V[j] - without.command.e_W_V[j],
                        std::copysign(std::min(0.05, limit_V), current_A[j]), 1e-12);
        }
    }
}

TEST_F(HapticLawTest, AlphaComesFromTheSourceInTheTuning) {
    const Configuration now = any_configuration();
    const contact::Contact contact = any_contact(now);
    Tuning tuning;
    tuning.alpha_rad2_per_m2 = 777.0;
    for (const auto &[mode, expected] : {std::pair(AlphaMode::global, kGlobalAlpha.global),
                                         std::pair(AlphaMode::by_hand, 777.0)}) {
        tuning.alpha_mode = mode;
        EXPECT_EQ(law(now, contact, tuning, kGlobalAlpha).alpha_rad2_per_m2, expected);
    }
    tuning.alpha_mode = AlphaMode::on_the_fly;
    const LawOutcome found = law(now, contact, tuning, kGlobalAlpha);
    const double bound = found.alpha_bound_rad2_per_m2;
    EXPECT_EQ(found.alpha_rad2_per_m2, bound);
    tuning.alpha_mode = AlphaMode::at_touch;
    EXPECT_EQ(law(now, contact, tuning, kGlobalAlpha).alpha_rad2_per_m2, bound);
    for (const double before : {0.9 * bound, 1.1 * bound}) {
        EXPECT_EQ(law(now, contact, tuning, {0.0, before}).alpha_rad2_per_m2,
                  std::min(before, bound));
    }
}

/// The energy [J] that a hand receives from a frictionless sphere of 30 mm, taken slowly along
/// waypoints below its surface, from touch to lift: ∫ F dx of the static force.
double received_J(const HapticLaw &law, const device::DeviceDescription &device, AlphaMode mode,
                  const std::vector<Vector3> &waypoints_m) {
    constexpr double kRadius_m = 0.03;
    constexpr double kStep_m = 20e-6;
    const Vector3 k_T = law.k_T();
    Tuning tuning;
    tuning.alpha_mode = mode;
    double alpha_before = std::numeric_limits<double>::infinity();
    double received_J = 0.0;
    Vector3 force_before_N = Vector3::Zero();
    for (std::size_t leg = 1; leg < waypoints_m.size(); ++leg) {
        const Vector3 way_m = waypoints_m[leg] - waypoints_m[leg - 1];
        const int steps = static_cast<int>(std::ceil(way_m.norm() / kStep_m));
        for (int i = 1; i <= steps; ++i) {
            const Vector3 tip_m = waypoints_m[leg - 1] + static_cast<double>(i) / steps * way_m;
            const Vector3 q_rad = *device::joint_angles_rad(device.geometry, tip_m);
            const Configuration now = law.configuration(
                device::motor_from_joint(device.geometry, q_rad), Vector3::Zero());
            contact::Contact contact;
            contact.touching = tip_m.norm() < kRadius_m;
            contact.x0_m = contact.touching ? Vector3(kRadius_m * tip_m.normalized()) : tip_m;
            contact.eta = contact.touching ? 0.0 : 1.0;
            contact.normal = tip_m.normalized();
            const LawOutcome found = law(now, contact, tuning, {0.0, alpha_before});
            alpha_before = contact.touching ? found.alpha_rad2_per_m2
                                            : std::numeric_limits<double>::infinity();
            const Vector3 force_N =
                now.J.transpose().inverse() *
                k_T.cwiseProduct(found.command.e_W_V).cwiseQuotient(found.dR_Ohm);
            received_J += 0.5 * (force_N + force_before_N).dot(way_m) / steps;
            force_before_N = force_N;
        }
    }
    return received_J;
}

// On the fly, pressed in where α is small and let out where it is large, it returns ½ Δα k̄ d² more
// than was put in. A spring that only becomes softer cannot.
TEST_F(HapticLawTest, AlphaAtTouchReturnsNoMoreThanWasPutIn) {
    // Of the trapezes where the surface is crossed, twice: ½ k (20 µm)² at 1.3 N/mm.
    constexpr double kCrossings_J = 2.0 * 0.26e-6;
    double on_the_fly_J = 0.0;
    for (int run = 0; run < 20; ++run) {
        std::vector<Vector3> waypoints_m;
        for (int i = 0; i < 6; ++i) { // at random depths of up to 3 mm, on the visible half
            Vector3 way = testing::random_vector(random, 1.0).normalized();
            way.z() = std::abs(way.z());
            const bool is_end = i == 0 || i == 5;
            std::uniform_real_distribution<double> radius_m(is_end ? 0.031 : 0.027,
                                                            is_end ? 0.032 : 0.0299);
            waypoints_m.push_back(radius_m(random) * way);
        }
        EXPECT_LT(received_J(law, device, AlphaMode::at_touch, waypoints_m), kCrossings_J);
        on_the_fly_J =
            std::max(on_the_fly_J, received_J(law, device, AlphaMode::on_the_fly, waypoints_m));
    }
    EXPECT_GT(on_the_fly_J, 0.1e-3); // not vacuous
}

TEST_F(HapticLawTest, TheBoundIsTheMinimumStiffnessOverDirections) {
    // (29) by brute force: 1/α is the largest |Jᵀ u|² of any unit vector u.
    for (int run = 0; run < 20; ++run) {
        const Configuration now = any_configuration();
        double largest = 0.0;
        for (int i = 0; i < 20'000; ++i) {
            const Vector3 u = testing::random_vector(random, 1.0).normalized();
            largest = std::max(largest, (now.J.transpose() * u).squaredNorm());
        }
        const double bound =
            law(now, contact::Contact{}, Tuning{}, kGlobalAlpha).alpha_bound_rad2_per_m2;
        EXPECT_LE(bound, 1.0 / largest * (1.0 + 1e-12));
        EXPECT_GT(bound, 0.999 / largest);
    }
}

TEST_F(HapticLawTest, WithoutASolutionTheInverseMapGivesNoForce) {
    const Configuration now = any_configuration();
    contact::Contact contact = any_contact(now);
    contact.eta = 0.0;
    contact.x0_m = Vector3(0.0, 1.0, 0.0); // a metre up: out of reach
    Tuning tuning;
    tuning.map = MotionMap::inverse;
    const LawOutcome found = law(now, contact, tuning, kGlobalAlpha);
    EXPECT_FALSE(found.inverse.has_value());
    EXPECT_LT((found.command.e_W_V - k_T * now.theta_rate_rad_per_s).norm(), 1e-12);
    EXPECT_EQ(found.used.theta_Sd_rad, now.theta_rad);
    // The transpose map still gives a force.
    tuning.map = MotionMap::transpose;
    EXPECT_GT(law(now, contact, tuning, kGlobalAlpha).command.e_W_V.norm(), 1.0);
}

TEST_F(HapticLawTest, RHatLeavesTheRequestedResidualAndNeverNone) {
    const Configuration now = any_configuration();
    for (const auto &[dR_Ohm, R_hat_Ohm] :
         {std::pair(0.5, 1.68), std::pair(2.18, 0.0), std::pair(3.0, 0.0), std::pair(0.02, 2.16),
          std::pair(0.0, 0.995 * 2.18), std::pair(-1.0, 0.995 * 2.18)}) {
        Tuning tuning;
        tuning.dR_Ohm = dR_Ohm;
        const device::DeviceCommand command =
            law(now, contact::Contact{}, tuning, kGlobalAlpha).command;
        EXPECT_LT((command.cancelled_resistance_Ohm.array() - R_hat_Ohm).abs().maxCoeff(), 1e-12);
    }
}

TEST_F(HapticLawTest, RHatUsesEachMotorsOwnResistance) {
    const double cold_Ohm = device.motor[0].resistance_Ohm;
    const Vector3 resistance_Ohm = cold_Ohm * Vector3(1.0, 1.2, 0.9);
    for (std::size_t j = 0; j < device.motor.size(); ++j) {
        device.motor[j].resistance_Ohm = resistance_Ohm[static_cast<Eigen::Index>(j)];
    }
    Tuning tuning;
    tuning.dR_Ohm = 0.5;
    const device::DeviceCommand command =
        HapticLaw(device)(any_configuration(), contact::Contact{}, tuning, kGlobalAlpha).command;
    const Vector3 residual_Ohm = resistance_Ohm - command.cancelled_resistance_Ohm;
    EXPECT_LT((residual_Ohm.array() - 0.5).abs().maxCoeff(), 1e-12) << residual_Ohm.transpose();
}

TEST_F(HapticLawTest, TheForceOfASetPointPointsAsItsMapDoes) {
    for (int run = 0; run < 200; ++run) {
        const Configuration now = any_configuration();
        const contact::Contact contact = any_contact(now);
        const LawOutcome found = law(now, contact, Tuning{}, kGlobalAlpha);
        const Vector3 direction = law.force_direction(now, found.transpose).normalized();
        EXPECT_LT((direction - contact.normal).norm(), 1e-7);
    }
}

} // namespace
} // namespace springdrive::control
