// Covers engine/lab/loops/stiffness_ellipse.cpp and engine/lab/loops/link_plane.h.
#include "engine/lab/loops/stiffness_ellipse.h"

#include "base/degrees.h"
#include "base/input_error.h"
#include "tests/support/devices.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace springdrive::loops {
namespace {

constexpr double kRoundOff = 1e-12; // a dozen operations on numbers of one size

/// Configurations well within the range of the links.
class RandomConfigurations {
public:
    Vector3 next() {
        const double q2 = uniform_(generator_) * 40.0;
        return kRadiansPerDegree *
               Vector3(uniform_(generator_) * 60.0, q2, q2 + uniform_(generator_) * 60.0);
    }

private:
    std::mt19937 generator_{3};
    std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

TEST(LinkPlane, JacobianIsTheDerivativeOfTheTipInThePlane) {
    const device::PhantomGeometry geometry = testing::phantom_premium_1_5().geometry;
    RandomConfigurations random;
    for (int i = 0; i < 200; ++i) {
        const Vector3 q = random.next();
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
    RandomConfigurations random;
    for (const device::DeviceDescription &device :
         {testing::phantom_1_0(), testing::phantom_premium_1_5()}) {
        for (int i = 0; i < 5; ++i) {
            const PlanarStiffness stiffness =
                planar_stiffness(device, control::Tuning{}, random.next());
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
    RandomConfigurations random;
    for (int i = 0; i < 200; ++i) {
        const Vector3 q = random.next();
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
    RandomConfigurations random;
    for (int i = 0; i < 50; ++i) {
        const Vector3 q = random.next();
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

} // namespace
} // namespace springdrive::loops
