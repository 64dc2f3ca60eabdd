// Covers engine/lab/loops/wrong_direction.cpp, and the scene made with it.
#include "engine/lab/loops/wrong_direction.h"

#include "assets/scenes/shapes.h"
#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/force_direction.h"
#include "engine/control/motion_control.h"
#include "engine/lab/limits/locked_device.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <random>

namespace springdrive::loops {
namespace {

device::DeviceDescription phantom() { return testing::phantom_1_0(); }

/// The largest angle between n and K n for a symmetric positive K, by its extreme eigenvalues.
double largest_angle_rad(const Matrix3 &K) {
    const Vector3 eigenvalues =
        Eigen::SelfAdjointEigenSolver<Matrix3>(K, Eigen::EigenvaluesOnly).eigenvalues();
    return std::asin((eigenvalues[2] - eigenvalues[0]) / (eigenvalues[2] + eigenvalues[0]));
}

PressSearch at_one_place(const Vector3 &tip_m) {
    PressSearch search;
    search.lower_m = search.upper_m = tip_m;
    search.depth_m = 1e-4; // harmless at every regular pose
    return search;
}

TEST(WrongDirection, AtOnePlaceItIsTheAngleThatTheEigenvaluesGive) {
    std::mt19937_64 random(5);
    int tried = 0;
    for (int i = 0; i < 40; ++i) {
        const Vector3 q_rad = testing::random_workspace_angles(phantom(), random);
        const auto found = most_wrong_press(
            phantom(), at_one_place(device::tip_position_m(phantom().geometry, q_rad)));
        if (!found) {
            continue; // beyond the joints' limits
        }
        const double error_rad = inverse_error_rad(phantom(), {}, *found);
        // The last step of the search turns the normal by 1e-6 rad.
        EXPECT_NEAR(error_rad, largest_angle_rad(inverse_tip_stiffness(phantom(), {}, q_rad)),
                    1e-6);
        ++tried;
    }
    EXPECT_GT(tried, 20);
}

TEST(WrongDirection, InThePlaneOfTheLinksItIsTheAngleBetweenThem) {
    const Vector3 q_rad = Vector3(0.0, -20.0, 15.0) * kRadiansPerDegree;
    const auto found = most_wrong_press(
        phantom(), at_one_place(device::tip_position_m(phantom().geometry, q_rad)));
    ASSERT_TRUE(found);
    // Of the base's motor the stiffness lies between those of the plane there.
    EXPECT_NEAR(inverse_error_rad(phantom(), {}, *found), 35.0 * kRadiansPerDegree, 1e-6);
    EXPECT_NEAR(found->normal.x(), 0.0, 1e-3);
}

TEST(WrongDirection, TheInverseErrorIsThatOfTheServosOwnMap) {
    const Vector3 q_rad = Vector3(10.0, -20.0, 15.0) * kRadiansPerDegree;
    const Press press{device::tip_position_m(phantom().geometry, q_rad), q_rad,
                      Vector3(0.3, 0.8, 0.4).normalized()};
    control::Configuration now;
    now.theta_rad = device::motor_from_joint(phantom().geometry, q_rad);
    now.tip_m = press.tip_m;
    now.J = device::motor_jacobian(phantom().geometry, q_rad);
    constexpr double kDepth_m = 1e-6; // the map bends by depth/link, 1e-5 rad
    const auto set_point = control::inverse_map(
        phantom().geometry, now, {press.tip_m + kDepth_m * press.normal, Vector3::Zero()});
    ASSERT_TRUE(set_point);
    const Vector3 force = control::static_tip_force(now.J, control::relative_stiffness(phantom()),
                                                    set_point->theta_Sd_rad - now.theta_rad);
    EXPECT_NEAR(inverse_error_rad(phantom(), {}, press),
                control::direction_error_rad(force, press.normal), 1e-4);
}

/// All presses of a grid that the search does not know of, by another way round.
double best_by_brute_force_rad(const device::DeviceDescription &device, const PressSearch &search,
                               int places, int angles) {
    double best_rad = 0.0;
    for (int i = 0; i <= places; ++i) {
        for (int j = 0; j <= places; ++j) {
            const Vector3 share(0.5, double(i) / places, double(j) / places);
            Press press;
            press.tip_m = search.lower_m + share.cwiseProduct(search.upper_m - search.lower_m);
            const auto q_rad = device::joint_angles_rad(device.geometry, press.tip_m);
            // 15° before the limits of assets/devices/phantom_1_0.toml.
            const Vector3 q_deg = q_rad ? Vector3(kDegreesPerRadian * *q_rad) : Vector3(90, 0, 0);
            const double fold_deg = q_deg[2] - q_deg[1];
            if (std::abs(q_deg[0]) > 75.0 || q_deg[1] < -109.0 || q_deg[1] > 104.0 ||
                q_deg[2] < -14.0 || q_deg[2] > 199.0 || fold_deg > 40.0 || fold_deg < -50.0) {
                continue;
            }
            press.q_rad = *q_rad;
            const Matrix3 K = inverse_tip_stiffness(device, search.tuning, *q_rad);
            for (int a = 0; a <= angles; ++a) {
                for (int b = 0; b < 4 * angles; ++b) {
                    const double polar_rad = M_PI * a / angles;
                    const double round_rad = M_PI * b / (2.0 * angles);
                    press.normal =
                        Vector3(std::sin(polar_rad) * std::cos(round_rad), std::cos(polar_rad),
                                std::sin(polar_rad) * std::sin(round_rad));
                    const Vector3 force = K * press.normal;
                    if (search.accepts(press)) {
                        best_rad =
                            std::max(best_rad, std::acos(force.normalized().dot(press.normal)));
                    }
                }
            }
        }
    }
    return best_rad;
}

TEST(WrongDirection, AFinerGridFindsNoMoreAndHardlyLess) {
    const PressSearch search = with_ease(phantom(), {});
    const auto found = most_wrong_press(phantom(), search);
    ASSERT_TRUE(found);
    const double found_rad = inverse_error_rad(phantom(), {}, *found);
    const double brute_rad = best_by_brute_force_rad(phantom(), search, 60, 45);
    EXPECT_LE(brute_rad, found_rad + 1e-6);
    // A grid of normals 4° apart misses a maximum, around which the angle falls by at most
    // Δ² (λ_max/λ_min) for Δ in rad, by less than 1°; one of places by none, as it has the corner.
    EXPECT_GT(brute_rad, found_rad - 1.0 * kRadiansPerDegree);
}

TEST(WrongDirection, WithEaseMeansWhatItSays) {
    const PressSearch search = with_ease(phantom(), {});
    const auto found = most_wrong_press(phantom(), search);
    ASSERT_TRUE(found);
    EXPECT_TRUE(search.accepts(*found));
    EXPECT_TRUE(((found->tip_m - search.lower_m).array() >= 0.0).all());
    EXPECT_TRUE(((search.upper_m - found->tip_m).array() >= 0.0).all());
    const double easy_rad = inverse_error_rad(phantom(), {}, *found);
    EXPECT_GT(easy_rad, 35.0 * kRadiansPerDegree);
    const auto anywhere = most_wrong_press(phantom(), everywhere(phantom(), {}));
    ASSERT_TRUE(anywhere);
    EXPECT_GT(inverse_error_rad(phantom(), {}, *anywhere), easy_rad);
    Press press = *found;
    press.normal = Vector3(0.0, std::cos(46.0 * kRadiansPerDegree), // too steep
                           std::sin(46.0 * kRadiansPerDegree));
    EXPECT_FALSE(search.accepts(press));
}

TEST(WrongDirection, WhatIsOutOfReachOrTooMuchForTheAmplifierIsNoPress) {
    EXPECT_FALSE(most_wrong_press(phantom(), at_one_place({0.0, 0.0, 0.5})));
    PressSearch deep = at_one_place(Vector3::Zero());
    EXPECT_TRUE(most_wrong_press(phantom(), deep));
    // In the zero pose some 1.8 N/mm, of which 4.25 N are allowed.
    deep.depth_m = 1e-3;
    EXPECT_TRUE(most_wrong_press(phantom(), deep));
    deep.depth_m = 4e-3;
    EXPECT_FALSE(most_wrong_press(phantom(), deep));
}

TEST(WrongDirection, TheTransposeMapErrsOnlyAsMotorsDiffer) {
    // In the zero pose J's columns are square to each other, so a normal between two of them is
    // turned by the arc tangent of the share.
    const Press press{Vector3::Zero(), Vector3::Zero(), Vector3(0.0, 1.0, 1.0).normalized()};
    EXPECT_NEAR(transpose_error_rad(phantom(), press, 0.0), 0.0, 1e-12);
    for (const double share : {0.01, 0.1, 0.3}) {
        EXPECT_NEAR(transpose_error_rad(phantom(), press, share), std::atan(share), 1e-12);
    }
}

TEST(WrongDirection, NoMixtureOfDifferencesTurnsTheTransposeMapFurther) {
    std::mt19937_64 random(9);
    constexpr double kShare = 0.09; // 2 % of R at dR 0.5 Ω
    std::uniform_real_distribution<double> differs(1.0 - kShare, 1.0 + kShare);
    const auto found = most_wrong_press(phantom(), with_ease(phantom(), {}));
    ASSERT_TRUE(found);
    const Matrix3 J = device::motor_jacobian(phantom().geometry, found->q_rad);
    const double largest_rad = transpose_error_rad(phantom(), *found, kShare);
    double seen_rad = 0.0;
    for (int i = 0; i < 2000; ++i) {
        const Vector3 D(differs(random), differs(random), differs(random));
        control::Configuration now;
        now.J = J;
        const Vector3 gap_rad = control::transpose_map(now, {1e-3 * found->normal, Vector3::Zero()},
                                                       1.0, Vector3::Ones())
                                    .theta_Sd_rad;
        seen_rad = std::max(seen_rad, control::direction_error_rad(
                                          control::static_tip_force(J, D, gap_rad), found->normal));
        ASSERT_LE(seen_rad, largest_rad + 1e-9);
    }
    EXPECT_GT(seen_rad, 0.8 * largest_rad); // so that it says something
}

const scenes::SceneDescription &own_scene() {
    static const std::vector<scenes::SceneDescription> all = scenes::all_scenes();
    return *std::ranges::find(all, "wrong_direction", &scenes::SceneDescription::name);
}

TEST(WrongDirectionScene, IsWhereTheSearchFindsTheMostAndSlopesAsItSays) {
    const auto found = most_wrong_press(phantom(), with_ease(phantom(), {}));
    ASSERT_TRUE(found);
    ASSERT_TRUE(own_scene().lesson.spot);
    const scenes::Spot &spot = *own_scene().lesson.spot;
    constexpr double kRounded_m = 1e-4;
    EXPECT_TRUE((spot.point_m - found->tip_m).isZero(kRounded_m)) << found->tip_m.transpose();
    EXPECT_LT(control::direction_error_rad(spot.normal, found->normal), 0.2 * kRadiansPerDegree)
        << found->normal.transpose();
}

/// The true force on a vice with a sensor, weight apart: of a device with motors and sensors of its
/// own, friction and encoders.
TEST(WrongDirectionScene, ThereTheTrueForceIsWrongWithOneMapAndRightWithTheOther) {
    const scenes::Spot &spot = *own_scene().lesson.spot;
    const double normal_rad = std::atan2(spot.normal.y(), spot.normal.z()); // from outward to up
    limits::LockedDeviceOptions options;
    options.q_rad = *device::joint_angles_rad(phantom().geometry, spot.point_m);
    options.device_seed = 3;
    options.observes_resistance = true;
    const auto error_deg = [&](control::MotionMap map) {
        options.penetration_m = limits::harmless_penetration_m(phantom(), {}, options.q_rad, map);
        return kDegreesPerRadian *
               std::abs(limits::press_locked_device(phantom(), options, map, normal_rad).error_rad);
    };
    EXPECT_GT(error_deg(control::MotionMap::inverse), 35.0);
    EXPECT_LT(error_deg(control::MotionMap::transpose), 5.0);
}

} // namespace
} // namespace springdrive::loops
