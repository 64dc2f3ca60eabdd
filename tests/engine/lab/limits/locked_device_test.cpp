// Covers engine/lab/limits/locked_device.cpp.
#include "engine/lab/limits/locked_device.h"

#include "base/degrees.h"
#include "base/input_error.h"
#include "engine/lab/loops/stiffness_ellipse.h"
#include "tests/support/devices.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace springdrive::limits {
namespace {

/// q₂ = 40°; the joint limits leave q₃ − q₂ more room on the negative side.
Vector3 folded(double q3_minus_q2_deg) {
    return kRadiansPerDegree * Vector3(0.0, 40.0, 40.0 + q3_minus_q2_deg);
}

LockedDeviceOptions without_effects(const Vector3 &q_rad) {
    LockedDeviceOptions options;
    options.q_rad = q_rad;
    options.effects = false;
    options.penetration_m = 1e-4; // the inverse map bends by up to Δx/l, here 0.04°
    return options;
}

/// The normal with the largest error of the inverse map, counter-clockwise. With the stiffnesses k₁
/// < k₂ along the ellipse's axes it lies at atan(√(k₁/k₂)) from the first.
double worst_normal_rad(const device::DeviceDescription &device, const Vector3 &q_rad) {
    const Eigen::SelfAdjointEigenSolver<loops::Matrix2> K(
        loops::planar_stiffness(device, control::Tuning{}, q_rad).inverse);
    const loops::Vector2 soft = K.eigenvectors().col(0);
    const double ratio = K.eigenvalues()[0] / K.eigenvalues()[1];
    return std::atan2(soft.y(), soft.x()) + std::atan(std::sqrt(ratio));
}

TEST(LockedDevice, ErrorOfTheInverseMapIsTheAngleBetweenTheLinks) {
    // Fig. 6's amplitude for five configurations: 0.1° is required.
    const device::DeviceDescription device = testing::phantom_1_0();
    for (const double fold_deg : {0.0, -15.0, -30.0, -45.0, -60.0}) {
        const LockedDeviceOptions options = without_effects(folded(fold_deg));
        const LockedForce force = press_locked_device(device, options, control::MotionMap::inverse,
                                                      worst_normal_rad(device, options.q_rad));
        EXPECT_NEAR(std::abs(force.error_rad) / kRadiansPerDegree, std::abs(fold_deg), 0.1);
        EXPECT_NEAR(force.error_rad / kRadiansPerDegree,
                    force.predicted_error_rad / kRadiansPerDegree, 0.1);
    }
}

TEST(LockedDevice, TransposePointsAlongTheNormal) {
    const device::DeviceDescription device = testing::phantom_1_0();
    for (const double fold_deg : {0.0, -30.0, -60.0}) {
        for (const double normal_deg : {-90.0, 10.0, 130.0}) {
            const LockedForce force =
                press_locked_device(device, without_effects(folded(fold_deg)),
                                    control::MotionMap::transpose, kRadiansPerDegree * normal_deg);
            EXPECT_LT(std::abs(force.error_rad) / kRadiansPerDegree, 0.01)
                << fold_deg << ' ' << normal_deg;
            EXPECT_NEAR(force.predicted_error_rad, 0.0, 1e-15);
        }
    }
}

TEST(LockedDevice, ForcesAreThoseOfTheStiffnessEllipse) {
    // Δx/l for the map, the proxy's clearance of 10 nm and the vice's own 1 µm/N.
    const double tolerance = 0.01;
    const device::DeviceDescription device = testing::phantom_1_0();
    LockedDeviceOptions options = without_effects(kRadiansPerDegree * Vector3(25.0, 20.0, -15.0));
    options.tuning.eta = 0.3;
    for (const control::MotionMap map :
         {control::MotionMap::inverse, control::MotionMap::transpose}) {
        for (const double normal_deg : {-90.0, 0.0, 45.0}) {
            const LockedForce force =
                press_locked_device(device, options, map, kRadiansPerDegree * normal_deg);
            EXPECT_LT((force.measured_N - force.predicted_N).norm(),
                      tolerance * force.predicted_N.norm())
                << normal_deg;
        }
    }
}

TEST(LockedDevice, ErrorOfTheTransposeMapIsSmallOnAnImperfectDevice) {
    // 5° is allowed; above a tenth of a degree somewhere, or the effects are missing.
    const device::DeviceDescription device = testing::phantom_1_0();
    for (const double fold_deg : {0.0, -15.0, -30.0, -45.0, -60.0}) {
        LockedDeviceOptions options;
        options.q_rad = folded(fold_deg);
        options.penetration_m = harmless_penetration_m(device, options.tuning, options.q_rad,
                                                       control::MotionMap::transpose);
        double largest_deg = 0.0;
        for (int normal_deg = 0; normal_deg < 360; normal_deg += 15) {
            const LockedForce force = press_locked_device(
                device, options, control::MotionMap::transpose, kRadiansPerDegree * normal_deg);
            largest_deg = std::max(largest_deg, std::abs(force.error_rad) / kRadiansPerDegree);
        }
        EXPECT_LT(largest_deg, 5.0) << fold_deg;
        EXPECT_GT(largest_deg, 0.1) << fold_deg;
        RecordProperty("largest_deg_" + std::to_string(-static_cast<int>(fold_deg)),
                       std::to_string(largest_deg));
    }
}

TEST(LockedDevice, ATripIsReported) {
    const device::DeviceDescription device = testing::phantom_1_0();
    LockedDeviceOptions options;
    options.q_rad = folded(-35.0);
    options.penetration_m = 4.0 * harmless_penetration_m(device, options.tuning, options.q_rad,
                                                         control::MotionMap::inverse);
    try {
        static_cast<void>(press_locked_device(device, options, control::MotionMap::inverse,
                                              worst_normal_rad(device, options.q_rad)));
        FAIL() << "no trip";
    } catch (const InputError &error) {
        EXPECT_NE(std::string(error.what()).find("limit"), std::string::npos) << error.what();
    }
}

TEST(LockedDevice, RefusesAnglesThatTheJointsCannotTurnTo) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const auto press = [&device](double q3_minus_q2_deg) {
        static_cast<void>(press_locked_device(device, without_effects(folded(q3_minus_q2_deg)),
                                              control::MotionMap::transpose, 0.0));
    };
    EXPECT_THROW(press(-66.0), InputError);
    EXPECT_NO_THROW(press(-64.0));
    EXPECT_THROW(press(NAN), InputError);
}

TEST(LockedDevice, HarmlessPenetrationKeepsWithinTheLimits) {
    // Against brute force: no normal requests more than half of either limit, and one requests all
    // of that half, unless the penetration is the largest there is.
    const device::DeviceDescription device = testing::phantom_premium_1_5();
    for (const double K_P : {0.5, 6.0, 20.0}) {
        control::Tuning tuning;
        tuning.K_P_V_per_rad = K_P;
        const Vector3 q = folded(-40.0);
        const double penetration_m =
            harmless_penetration_m(device, tuning, q, control::MotionMap::inverse);
        const loops::PlanarStiffness stiffness = loops::planar_stiffness(device, tuning, q);
        const loops::Matrix2 J = loops::planar_jacobian(device.geometry, q);
        double share = 0.0;
        for (int i = 0; i < 3600; ++i) {
            const loops::Vector2 force = penetration_m * stiffness.inverse *
                                         loops::direction_at(0.1 * kRadiansPerDegree * i);
            const loops::Vector2 current_A =
                J.transpose() * force / device.motor[1].torque_constant_Nm_per_A;
            share = std::max({share, force.norm() / device.limits.tip_force_N,
                              current_A.cwiseAbs().maxCoeff() / device.motor[1].peak_current_A});
        }
        EXPECT_LE(share, 0.5 + 1e-12);
        if (penetration_m < 4e-3) {
            EXPECT_GT(share, 0.5 * (1.0 - 1e-5)); // a normal 0.05° off the worst
        }
    }
}

} // namespace
} // namespace springdrive::limits
