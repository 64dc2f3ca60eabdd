// Covers the secants of device/core/phantom/dynamics.h, the basis of the
// plant's exact energy.
#include "device/core/phantom/dynamics.h"

#include "device/core/phantom/kinematics.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace springdrive::device {
namespace {

constexpr double kSecantRoundOff = 10.0 * std::numeric_limits<double>::epsilon();

/// Two configurations, from a radian apart down to a distance of round-off.
struct Pair {
    Vector3 a{Vector3::Zero()};
    Vector3 b{Vector3::Zero()};

    [[nodiscard]] Vector3 way() const { return b - a; }
    [[nodiscard]] Vector3 middle() const { return 0.5 * (a + b); }
};

class Secants : public ::testing::TestWithParam<DeviceDescription> {
protected:
    [[nodiscard]] Pair any_pair(double way_rad) {
        const Vector3 a = testing::random_workspace_angles(GetParam(), random);
        return {a, a + testing::random_vector(random, way_rad)};
    }
    [[nodiscard]] Vector3 any_vector() { return testing::random_vector(random, 1.0); }
    [[nodiscard]] const PhantomGeometry &geometry() const { return GetParam().geometry; }

    std::mt19937_64 random{51};
    LinkageMoments moments = linkage_moments(GetParam().geometry, GetParam().inertia, 0.05);
};

TEST_P(Secants, GiveTheExactChangeBetweenTheEnds) {
    for (int i = 0; i < 1000; ++i) {
        const Pair q = any_pair(std::pow(10.0, -(i % 15)));
        const Vector3 u = any_vector();
        const Vector3 v = any_vector();
        const Vector3 moved_m = tip_position_m(geometry(), q.b) - tip_position_m(geometry(), q.a);
        ASSERT_LT((tip_secant(geometry(), q.a, q.b) * q.way() - moved_m).norm(), kSecantRoundOff);

        const Matrix3 M_a = mass_matrix(moments, q.a);
        const Matrix3 M_b = mass_matrix(moments, q.b);
        ASSERT_NEAR(q.way().dot(inertia_secant(moments, q.a, q.b, u) * v),
                    0.5 * u.dot((M_b - M_a) * v), kSecantRoundOff * M_a.norm());

        ASSERT_NEAR(gravity_secant_Nm(moments, q.a, q.b).dot(q.way()),
                    gravity_energy_J(moments, q.b) - gravity_energy_J(moments, q.a),
                    kSecantRoundOff);
    }
}

TEST_P(Secants, EqualTheDerivativesForCoincidingEnds) {
    for (int i = 0; i < 1000; ++i) {
        const Pair q = any_pair(0.0);
        ASSERT_LT((tip_secant(geometry(), q.a, q.a) - joint_jacobian(geometry(), q.a)).norm(),
                  kSecantRoundOff);
        ASSERT_EQ(gravity_secant_Nm(moments, q.a, q.a), gravity_torque_Nm(moments, q.a));
        // The rows of Γ are ½ uᵀ ∂M/∂q, here by central differences: h² and ε/h, 1e-10 together.
        constexpr double kStep = 1e-5;
        const Vector3 u = any_vector();
        const Matrix3 gamma = inertia_secant(moments, q.a, q.a, u);
        for (int joint = 0; joint < 3; ++joint) {
            const Vector3 step = kStep * Vector3::Unit(joint);
            const Matrix3 slope =
                (mass_matrix(moments, q.a + step) - mass_matrix(moments, q.a - step)) /
                (2.0 * kStep);
            ASSERT_LT((gamma.row(joint) - 0.5 * u.transpose() * slope).norm(),
                      1e-9 * mass_matrix(moments, q.a).norm());
        }
    }
}

TEST_P(Secants, AreSecondOrderAboutTheMiddleForAnyDistance) {
    // Difference quotients would lose all digits at small distances; these lose none.
    for (int i = 0; i < 1000; ++i) {
        const double way_rad = std::pow(10.0, -(i % 15));
        const Pair q = any_pair(way_rad);
        const Vector3 u = any_vector();
        // Frequencies of up to 2 in each of three angles: 3 · (2 d)²/8, and more for mixed terms.
        const double relative = 5.0 * way_rad * way_rad + kSecantRoundOff;
        const Matrix3 J = joint_jacobian(geometry(), q.middle());
        ASSERT_LT((tip_secant(geometry(), q.a, q.b) - J).norm(), relative * J.norm());
        ASSERT_LT((inertia_secant(moments, q.a, q.b, u) -
                   inertia_secant(moments, q.middle(), q.middle(), u))
                      .norm(),
                  relative * mass_matrix(moments, q.a).norm());
        ASSERT_LT(
            (gravity_secant_Nm(moments, q.a, q.b) - gravity_torque_Nm(moments, q.middle())).norm(),
            relative);
    }
}

TEST_P(Secants, OfTwoJointsEqualThoseOfThreeWithTheBaseAtRest) {
    for (int i = 0; i < 1000; ++i) {
        Pair q = any_pair(std::pow(10.0, -(i % 15)));
        q.b[0] = q.a[0];
        Vector3 u = any_vector();
        u[0] = 0.0;
        const LinkageSecants<2> two(q.a, q.b);
        const Vector3 outward(std::sin(q.a[0]), 0.0, std::cos(q.a[0]));
        Eigen::Matrix<double, 3, 2> tip = outward * two.tip(geometry()).row(0);
        tip.row(1) += two.tip(geometry()).row(1);
        ASSERT_LT((tip - tip_secant(geometry(), q.a, q.b).rightCols<2>()).norm(), kSecantRoundOff);
        const Eigen::Matrix2d gamma = two.inertia(moments, u.tail<2>());
        ASSERT_LT((gamma - inertia_secant(moments, q.a, q.b, u).bottomRightCorner<2, 2>()).norm(),
                  kSecantRoundOff);
        ASSERT_EQ(two.gravity_Nm(moments), gravity_secant_Nm(moments, q.a, q.b).tail<2>());
        ASSERT_EQ(mass_matrix_of_plane(moments, LinkSines::of(q.a)),
                  (mass_matrix(moments, q.a).bottomRightCorner<2, 2>()));
    }
}

INSTANTIATE_TEST_SUITE_P(Devices, Secants,
                         ::testing::Values(testing::phantom_1_0(), testing::phantom_premium_1_5()),
                         [](const auto &instance) {
                             return instance.param.geometry.upper_arm_m < 0.2 ? "Phantom10"
                                                                              : "Premium15";
                         });

} // namespace
} // namespace springdrive::device
