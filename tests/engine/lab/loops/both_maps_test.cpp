// Covers engine/lab/loops/both_maps.cpp and link_plane.cpp.
#include "engine/lab/loops/both_maps.h"

#include "assets/scenes/shapes.h"
#include "base/degrees.h"
#include "base/input_error.h"
#include "device/core/motor/motor.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/haptic_law.h"
#include "engine/control/rendered_force.h"
#include "engine/lab/limits/locked_device.h"
#include "engine/lab/loops/link_plane.h"
#include "tests/support/devices.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace springdrive::loops {
namespace {

constexpr double kRoundOffOfMaps = 1e-9; // inverse kinematics and a 3×3 inverse

/// Configurations well within the range of the links, and off the base's axis, where J is singular.
class ManyPoses {
public:
    Vector3 next_rad() {
        Vector3 q_rad = Vector3::Zero();
        double share = 0.0; // of the links' length, from the axis
        while (share < 0.5) {
            const double q2 = uniform_(generator_) * 40.0;
            q_rad = kRadiansPerDegree *
                    Vector3(uniform_(generator_) * 60.0, q2, q2 + uniform_(generator_) * 60.0);
            share = std::cos(q_rad[1]) + std::sin(q_rad[2]);
        }
        return q_rad;
    }
    Vector3 direction() {
        return Vector3(uniform_(generator_), uniform_(generator_), uniform_(generator_))
            .normalized();
    }

private:
    std::mt19937 generator_{11};
    std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

/// At rest, pressed by `depth_m` into a rigid surface.
struct Pressed {
    control::Configuration now;
    contact::Contact contact;
};

Pressed pressed(const device::DeviceDescription &device, const Vector3 &q_rad,
                const Vector3 &normal, double depth_m) {
    const Vector3 theta_rad = device::motor_from_joint(device.geometry, q_rad);
    Pressed made{control::HapticLaw(device).configuration(theta_rad, Vector3::Zero()), {}};
    made.contact.touching = true;
    made.contact.normal = normal;
    made.contact.x0_m = made.now.tip_m + depth_m * normal;
    made.contact.eta = 0.0;
    return made;
}

TEST(BothMaps, TransposeForceIsAlongTheNormalAsStiffAsTheClosedForm) {
    // (27) with (29) for equal links: α = min(N²/(l² (1 + |sin(q₃ − q₂)|)), N₁²/r²), where r is the
    // tip's distance from the base's axis, as the base's column of J is square to the others.
    const device::DeviceDescription device = testing::phantom_1_0();
    const device::PhantomGeometry &g = device.geometry;
    ASSERT_EQ(g.upper_arm_m, g.forearm_m);
    ASSERT_EQ(g.transmission_ratio[1], g.transmission_ratio[2]);
    control::Tuning tuning;
    tuning.eta = 0.25;
    const double K_DC = device.motor[0].torque_constant_Nm_per_A * tuning.K_P_V_per_rad /
                        tuning.dR_Ohm; // (13); its motors are alike
    ManyPoses poses;
    for (int i = 0; i < 100; ++i) {
        const Vector3 q_rad = poses.next_rad();
        const Vector3 normal = poses.direction();
        const double r_m = g.upper_arm_m * std::cos(q_rad[1]) + g.forearm_m * std::sin(q_rad[2]);
        const double in_plane = std::pow(g.transmission_ratio[1] / g.upper_arm_m, 2.0) /
                                (1.0 + std::abs(std::sin(q_rad[2] - q_rad[1])));
        const double alpha = std::min(in_plane, std::pow(g.transmission_ratio[0] / r_m, 2.0));
        constexpr double kDepth_m = 0.004;
        const Pressed press = pressed(device, q_rad, normal, kDepth_m);
        const MapForces forces = map_forces(device, press.now, press.contact, tuning, 0.0);
        const Vector3 expected_N = 0.75 * alpha * K_DC * kDepth_m * normal;
        EXPECT_LT((forces.transpose_N - expected_N).norm(), kRoundOffOfMaps * expected_N.norm());
        const auto stiffness = map_stiffness(device, tuning, q_rad, alpha);
        ASSERT_TRUE(stiffness);
        EXPECT_NEAR(stiffness->transpose_N_per_m * kDepth_m, expected_N.norm(),
                    kRoundOffOfMaps * expected_N.norm());
    }
}

TEST(BothMaps, InverseForceDoesTheWorkOfTheMotorsTorques) {
    // Virtual work: F · ∂x/∂θ_j = K_q (θ_Sd − θ)_j, with ∂x/∂θ by differences of the kinematics.
    const device::DeviceDescription device = testing::phantom_premium_1_5();
    const control::Tuning tuning;
    ManyPoses poses;
    for (int i = 0; i < 50; ++i) {
        const Vector3 q_rad = poses.next_rad();
        const Pressed press = pressed(device, q_rad, poses.direction(), 0.003);
        const MapForces forces = map_forces(device, press.now, press.contact, tuning, 0.0);
        ASSERT_TRUE(forces.inverse_N);
        const Vector3 q_Sd_rad =
            device::joint_angles_rad(device.geometry, press.contact.x0_m).value();
        for (Eigen::Index j = 0; j < 3; ++j) {
            const auto motor = static_cast<std::size_t>(j);
            const double K_q =
                device.motor[motor].torque_constant_Nm_per_A * tuning.K_P_V_per_rad / tuning.dR_Ohm;
            const double ratio = device.geometry.transmission_ratio[j];
            const double torque_Nm = K_q * ratio * (q_Sd_rad[j] - q_rad[j]);
            constexpr double kStep_rad = 1e-5; // central: error of the order of its square
            const Vector3 turn = kStep_rad * Vector3::Unit(j);
            const Vector3 way_m = (device::tip_position_m(device.geometry, q_rad + turn) -
                                   device::tip_position_m(device.geometry, q_rad - turn)) /
                                  (2.0 * kStep_rad * ratio);
            EXPECT_NEAR(forces.inverse_N->dot(way_m), torque_Nm, 1e-7) << i << ' ' << j;
        }
    }
}

TEST(BothMaps, StiffnessOfTheInverseMapIsTheSlopeOfItsForce) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const control::Tuning tuning;
    ManyPoses poses;
    for (int i = 0; i < 50; ++i) {
        const Vector3 q_rad = poses.next_rad();
        const auto stiffness = map_stiffness(device, tuning, q_rad, 1.0);
        ASSERT_TRUE(stiffness);
        for (int axis = 0; axis < 3; ++axis) {
            constexpr double kStep_m = 1e-5;
            const auto force_N = [&](double depth_m) {
                const Pressed press = pressed(device, q_rad, Vector3::Unit(axis), depth_m);
                return map_forces(device, press.now, press.contact, tuning, 0.0).inverse_N.value();
            };
            const Vector3 slope = (force_N(kStep_m) - force_N(-kStep_m)) / (2.0 * kStep_m);
            const Vector3 column = stiffness->inverse_N_per_m.col(axis);
            // Curved kinematics: of the order of (step/link)².
            EXPECT_LT((slope - column).norm(), 1e-5 * stiffness->inverse_N_per_m.norm());
        }
    }
}

TEST(BothMaps, LargestErrorIsThatOfTheWorstNormal) {
    const device::DeviceDescription device = testing::phantom_1_0();
    ManyPoses poses;
    for (int i = 0; i < 10; ++i) {
        const Matrix3 K = map_stiffness(device, {}, poses.next_rad(), 1.0).value().inverse_N_per_m;
        double worst_rad = 0.0;
        constexpr int kAround = 600;
        for (int row = 0; row <= kAround; ++row) {
            for (int column = 0; column < kAround; ++column) {
                const double latitude = std::numbers::pi * row / kAround;
                const double longitude = std::numbers::pi * column / kAround; // n and −n are alike
                const Vector3 n(std::sin(latitude) * std::cos(longitude),
                                std::sin(latitude) * std::sin(longitude), std::cos(latitude));
                worst_rad = std::max(worst_rad, control::direction_error_rad(K * n, n));
            }
        }
        const double found_rad = largest_error_rad(K);
        EXPECT_LE(worst_rad, found_rad + 1e-12);
        EXPECT_GT(worst_rad, found_rad - 1e-3); // between neighbours of the grid
    }
    EXPECT_NEAR(largest_error_rad(3.0 * Matrix3::Identity()), 0.0, 1e-7);
    EXPECT_TRUE(std::isnan(largest_error_rad(Matrix3::Zero())));
}

TEST(BothMaps, WorkspaceHoldsPlacesThatTheTipCanReachAndTheirValues) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const control::Tuning tuning;
    constexpr double kSpacing_m = 0.03;
    const auto errors = errors_in_workspace_rad(device, tuning, kSpacing_m);
    const auto stiffnesses = stiffnesses_in_workspace_N_per_m(device, tuning, kSpacing_m);
    ASSERT_GT(errors.size(), 50U);
    ASSERT_EQ(errors.size(), stiffnesses.size());
    for (std::size_t i = 0; i < errors.size(); ++i) {
        EXPECT_TRUE(device::can_reach(device, errors[i].tip_m));
        const Vector3 beside_m = errors[i].tip_m - device.workspace.centre_m;
        EXPECT_TRUE(
            (beside_m.array().abs() <= 0.5 * device.workspace.size_m.array() + 1e-12).all());
        const Vector3 q_rad = device::joint_angles_rad(device.geometry, errors[i].tip_m).value();
        // In the plane of the links alone it is |q₃ − q₂|: other normals may only add to it.
        EXPECT_GE(errors[i].value, std::abs(q_rad[2] - q_rad[1]) - 1e-9);
        EXPECT_LT(errors[i].value, 0.5 * std::numbers::pi);
        // (28): no direction of the inverse map is softer than the transpose map's sphere.
        const Matrix3 K = map_stiffness(device, tuning, q_rad, 1.0).value().inverse_N_per_m;
        const Vector3 n = Vector3(0.2, 0.5, -0.8).normalized();
        EXPECT_GE((K * n).norm(), stiffnesses[i].value * (1.0 - 1e-9));
    }
}

constexpr double kRoundOff = 1e-12; // a dozen operations on numbers of one size

TEST(LinkPlane, JacobianIsTheDerivativeOfTheTipInThePlane) {
    const device::PhantomGeometry geometry = testing::phantom_premium_1_5().geometry;
    ManyPoses random;
    for (int i = 0; i < 200; ++i) {
        const Vector3 q = random.next_rad();
        const Matrix2 J = planar_jacobian(geometry, q);
        for (Eigen::Index j = 0; j < 2; ++j) {
            constexpr double kStep_rad = 1e-5; // central: error of the order of its square
            const Vector3 turn = kStep_rad * Vector3::Unit(j + 1);
            const Vector3 way = device::tip_position_m(geometry, q + turn) -
                                device::tip_position_m(geometry, q - turn);
            const Vector2 column = link_plane(q[0]).transpose() * way /
                                   (2.0 * kStep_rad * geometry.transmission_ratio[j + 1]);
            EXPECT_LT((J.col(j) - column).norm(), 1e-8 * column.norm());
            EXPECT_LT(std::abs(way.dot(Vector3(std::cos(q[0]), 0.0, -std::sin(q[0])))), 1e-15);
        }
    }
}

TEST(StiffnessEllipse, TheCircleIsInscribed) {
    // (28) with equality: the circle's radius is the ellipse's small semi-axis, found here by
    // going around instead of by eigenvalues.
    constexpr int kPoints = 36'000;
    const double missed = std::pow(std::numbers::pi / kPoints, 2); // by a point next to the axis
    ManyPoses random;
    for (const device::DeviceDescription &device :
         {testing::phantom_1_0(), testing::phantom_premium_1_5()}) {
        for (int i = 0; i < 5; ++i) {
            const PlanarStiffness stiffness =
                planar_stiffness(device, control::Tuning{}, random.next_rad());
            double minimum = INFINITY;
            for (const EllipsePoint &point : stiffness_ellipses(stiffness, kPoints)) {
                EXPECT_NEAR(point.transpose_N_per_m.norm(), stiffness.transpose(0, 0),
                            kRoundOff * stiffness.transpose(0, 0));
                minimum = std::min(minimum, point.inverse_N_per_m.norm());
            }
            const double eccentric = stiffness.inverse.norm() / stiffness.transpose(0, 0);
            EXPECT_NEAR(minimum / stiffness.transpose(0, 0), 1.0,
                        eccentric * eccentric * missed + kRoundOff);
        }
    }
}

TEST(StiffnessEllipse, AlphaIsThatOfTheClosedForm) {
    // docs/design.md, "Linkage and motors": α = N²/(l² (1 + |sin(q₃ − q₂)|)) for equal links and
    // ratios.
    const device::DeviceDescription device = testing::phantom_1_0();
    const double l = device.geometry.forearm_m;
    const double N = device.geometry.transmission_ratio[1];
    ManyPoses random;
    for (int i = 0; i < 200; ++i) {
        const Vector3 q = random.next_rad();
        const double expected = N * N / (l * l * (1.0 + std::abs(std::sin(q[2] - q[1]))));
        EXPECT_NEAR(planar_stiffness(device, control::Tuning{}, q).alpha_rad2_per_m2, expected,
                    kRoundOff * expected);
    }
}

TEST(StiffnessEllipse, ForcesFollowFromTorquesOfTheHeldMotors) {
    // (19), (22) step by step, with motors that differ: hold the motors, move the tip, add the
    // torques' forces.
    device::DeviceDescription device = testing::phantom_1_0();
    device.motor[2].torque_constant_Nm_per_A *= 1.3;
    control::Tuning tuning;
    tuning.eta = 0.25;
    ManyPoses random;
    for (int i = 0; i < 50; ++i) {
        const Vector3 q = random.next_rad();
        const PlanarStiffness stiffness = planar_stiffness(device, tuning, q);
        const Matrix2 J = planar_jacobian(device.geometry, q);
        const Vector2 n = direction_at(0.1 * i);
        const Vector2 turn = J.colPivHouseholderQr().solve(n);
        const Vector2 k_T(device.motor[1].torque_constant_Nm_per_A,
                          device.motor[2].torque_constant_Nm_per_A);
        const Vector2 torque = 0.75 * tuning.K_P_V_per_rad / tuning.dR_Ohm * k_T.cwiseProduct(turn);
        const Vector2 force = stiffness.inverse * n;
        EXPECT_LT((J.transpose() * force - torque).norm(), kRoundOff * 10.0 * torque.norm());
        EXPECT_NEAR(
            inverse_direction_error_rad(stiffness, 0.1 * i),
            std::remainder(std::atan2(force.y(), force.x()) - 0.1 * i, 2.0 * std::numbers::pi),
            10.0 * kRoundOff);
        // Still isotropic, and within the ellipse.
        const Eigen::SelfAdjointEigenSolver<Matrix2> inverse(stiffness.inverse);
        EXPECT_LT(stiffness.transpose(0, 0), inverse.eigenvalues().maxCoeff());
    }
}

TEST(StiffnessEllipse, TheLargestErrorIsTheAngleBetweenTheLinks) {
    // docs/design.md, "Linkage and motors", by going around: near its maximum the error is flat,
    // and a normal 0.01° from it has an error of the square of that.
    const device::DeviceDescription device = testing::phantom_1_0();
    for (const double fold_deg : {-60.0, -45.0, -30.0, -15.0, 0.0, 20.0, 50.0}) {
        const Vector3 q = kRadiansPerDegree * Vector3(0.0, 20.0, 20.0 + fold_deg);
        const PlanarStiffness stiffness = planar_stiffness(device, control::Tuning{}, q);
        double largest = 0.0;
        for (int i = 0; i < 36'000; ++i) {
            largest = std::max(largest, std::abs(inverse_direction_error_rad(
                                            stiffness, 0.01 * kRadiansPerDegree * i)));
        }
        EXPECT_NEAR(largest / kRadiansPerDegree, std::abs(fold_deg), 1e-4);
    }
}

TEST(StiffnessEllipse, RefusesCasesWithoutASolution) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const Vector3 q = kRadiansPerDegree * Vector3(0.0, 20.0, -15.0);
    EXPECT_THROW(static_cast<void>(planar_stiffness(device, control::Tuning{},
                                                    kRadiansPerDegree * Vector3(0.0, 40.0, -50.0))),
                 InputError);
    EXPECT_NO_THROW(static_cast<void>(planar_stiffness(
        device, control::Tuning{}, kRadiansPerDegree * Vector3(0.0, 40.0, -49.9))));
    control::Tuning limp;
    limp.K_P_V_per_rad = 0.0;
    EXPECT_THROW(static_cast<void>(planar_stiffness(device, limp, q)), InputError);
    control::Tuning free;
    free.eta = 1.0;
    EXPECT_THROW(static_cast<void>(planar_stiffness(device, free, q)), InputError);
}

const device::DeviceDescription &phantom() {
    static const device::DeviceDescription device = testing::phantom_1_0();
    return device;
}

const scenes::Spot &spot() {
    static const std::vector<scenes::SceneDescription> all = scenes::all_scenes();
    return std::ranges::find(all, "wrong_direction", &scenes::SceneDescription::name)
        ->lesson.spot.value();
}

/// Whether a press is easy to make and to see: from above on what slopes by 45° at most, 15 mm or
/// more below a tip that starts in the zero pose, which has it at the origin, with the forearm 30°
/// or more off the surface; by joints that are 15° before the limits of
/// assets/devices/phantom_1_0.toml.
bool is_easy(const Vector3 &q_rad, const Vector3 &tip_m, const Vector3 &normal) {
    const Vector3 q_deg = kDegreesPerRadian * q_rad;
    const double fold_deg = q_deg[2] - q_deg[1];
    if (std::abs(q_deg[0]) > 75.0 || q_deg[1] < -109.0 || q_deg[1] > 104.0 || q_deg[2] < -14.0 ||
        q_deg[2] > 199.0 || fold_deg > 40.0 || fold_deg < -50.0) {
        return false;
    }
    const device::LinkagePose pose = device::linkage_pose(phantom().geometry, q_rad);
    return normal.y() >= std::cos(45.0 * kRadiansPerDegree) && normal.dot(-tip_m) >= 0.015 &&
           (pose.elbow_m - pose.tip_m).normalized().dot(normal) >= 0.5;
}

/// The largest error of a grid of easy presses in the middle plane of the inner 80 % of the
/// workspace [rad].
double worst_of_a_grid_rad(int places, int angles) {
    const device::DeviceDescription &device = phantom();
    double worst_rad = 0.0;
    for (int i = 0; i <= places * places + 2 * places; ++i) {
        const Vector3 share(0.0, static_cast<double>(i % (places + 1)) / places - 0.5,
                            static_cast<double>(i / (places + 1)) / places - 0.5);
        const Vector3 tip_m =
            device.workspace.centre_m + 0.8 * share.cwiseProduct(device.workspace.size_m);
        const auto q_rad = device::joint_angles_rad(device.geometry, tip_m);
        if (!q_rad) {
            continue;
        }
        const Matrix3 K = inverse_tip_stiffness(device, {}, *q_rad);
        for (int a = 0; a <= angles; ++a) { // from vertical to 45°
            for (int b = 0; b < 8 * angles; ++b) {
                const double polar_rad = M_PI * a / (4.0 * angles);
                const double round_rad = M_PI * b / (4.0 * angles);
                const Vector3 normal(std::sin(polar_rad) * std::cos(round_rad), std::cos(polar_rad),
                                     std::sin(polar_rad) * std::sin(round_rad));
                if (is_easy(*q_rad, tip_m, normal)) {
                    worst_rad =
                        std::max(worst_rad, control::direction_error_rad(K * normal, normal));
                }
            }
        }
    }
    return worst_rad;
}

TEST(WrongDirectionScene, IsWhereTheInverseMapErrsMostOfAllEasyPresses) {
    const Vector3 q_rad = device::joint_angles_rad(phantom().geometry, spot().point_m).value();
    const Vector3 beside_m = spot().point_m - phantom().workspace.centre_m;
    EXPECT_TRUE((beside_m.array().abs() <= 0.4 * phantom().workspace.size_m.array() + 1e-4).all());
    const double error_rad = control::direction_error_rad(
        inverse_tip_stiffness(phantom(), {}, q_rad) * spot().normal, spot().normal);
    EXPECT_GT(error_rad, 35.0 * kRadiansPerDegree);
    const double worst_rad = worst_of_a_grid_rad(40, 12);
    EXPECT_LE(worst_rad, error_rad + 0.2 * kRadiansPerDegree); // the spot's numbers are rounded
    // Normals 4° apart miss a maximum, around which the angle falls by at most Δ² (λ_max/λ_min) for
    // Δ in rad, by less than 1°; places 2 % of the box apart by less than half of that.
    EXPECT_GT(worst_rad, error_rad - 1.5 * kRadiansPerDegree);
}

/// The true force on a vice with a sensor, weight apart: of a device with motors and sensors of its
/// own, friction and encoders.
TEST(WrongDirectionScene, ThereTheTrueForceIsWrongWithOneMapAndRightWithTheOther) {
    const double normal_rad =
        std::atan2(spot().normal.y(), spot().normal.z()); // from outward to up
    limits::LockedDeviceOptions options;
    options.q_rad = *device::joint_angles_rad(phantom().geometry, spot().point_m);
    options.device_seed = 3;
    options.observes_resistance = true;
    const auto error_deg = [&](control::MotionMap map) {
        options.penetration_m = limits::harmless_penetration_m(phantom(), {}, options.q_rad, map);
        return kDegreesPerRadian *
               std::abs(limits::press_locked_device(phantom(), options, map, normal_rad).error_rad);
    };
    EXPECT_GT(error_deg(control::MotionMap::inverse), 35.0);
    EXPECT_LT(error_deg(control::MotionMap::transpose), 10.0); // 5 without brushes
}

} // namespace
} // namespace springdrive::loops
