// Covers device/core/phantom/dynamics.cpp.
#include "device/core/phantom/dynamics.h"

#include "device/core/phantom/kinematics.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <optional>
#include <random>
#include <type_traits>

namespace springdrive::device {
namespace {

constexpr double kRoundOff = 10.0 * std::numeric_limits<double>::epsilon();
constexpr double kTipLoad_kg = 0.05;

/// Of a smooth function of t at 0, by the five-point rule: truncation h⁴/30 and round-off 1.5 ε/h
/// make about 1e-12 together for a function of size and frequency 1.
template <typename Function>
std::invoke_result_t<Function, double> derivative(const Function &function) {
    using Value = std::invoke_result_t<Function, double>;
    constexpr double kStep = 5e-4;
    const Value near = function(kStep) - function(-kStep);
    const Value far = function(2.0 * kStep) - function(-2.0 * kStep);
    return (8.0 * near - far) / (12.0 * kStep);
}
constexpr double kDerivative = 1e-11;

/// A body of the linkage in space, derived from the drawing: its centre from the base joint, and
/// its axes (normal to the plane, across the link, along the link) as columns.
struct PlacedBody {
    Vector3 centre_m{Vector3::Zero()};
    Matrix3 axes{Matrix3::Identity()};
};

/// Properties of a body independent of its position.
struct Body {
    double mass_kg = 0.0;
    Vector3 inertia_kg_m2{Vector3::Zero()};
    double carried_kg = 0.0; ///< mass not contained in the inertia, which is about the centre
};

constexpr std::size_t kBodies = 5; ///< upper arm, crank, rod, forearm, tip load

std::array<Body, kBodies> bodies(const DeviceDescription &device) {
    const LinkageInertia &i = device.inertia;
    return {{{i.upper_arm.mass_kg, i.upper_arm.inertia_kg_m2, 0.0},
             {i.crank.mass_kg, i.crank.inertia_kg_m2, 0.0},
             {i.rod.mass_kg, i.rod.inertia_kg_m2, i.rod.mass_kg},
             {i.forearm.mass_kg, i.forearm.inertia_kg_m2, i.forearm.mass_kg},
             {kTipLoad_kg, Vector3::Zero(), kTipLoad_kg}}};
}

std::array<PlacedBody, kBodies> placed(const DeviceDescription &device, const Vector3 &q) {
    const Matrix3 base = Eigen::AngleAxisd(q[0], Vector3::UnitY()).toRotationMatrix();
    // With q₂ the arm turns from straight out (z) upwards (y), with q₃ the forearm from straight
    // down outwards: both turn about −x.
    const Matrix3 arm = base * Eigen::AngleAxisd(-q[1], Vector3::UnitX()).toRotationMatrix();
    const Matrix3 forearm = base * Eigen::AngleAxisd(-q[2], Vector3::UnitX()).toRotationMatrix();
    const Vector3 along_arm = arm * Vector3::UnitZ();
    const Vector3 along_forearm = forearm * -Vector3::UnitY();
    Matrix3 down; // normal, across and along of a link that hangs
    down << Vector3::UnitX(), Vector3::UnitZ(), -Vector3::UnitY();

    const PhantomGeometry &g = device.geometry;
    const LinkageInertia &i = device.inertia;
    const Vector3 elbow = g.upper_arm_m * along_arm;
    return {{{i.upper_arm.centre_m * along_arm, arm},
             {i.crank.centre_m * along_forearm, forearm * down},
             {g.crank_m * along_forearm + i.rod.centre_m * along_arm, arm},
             {elbow + i.forearm.centre_m * along_forearm, forearm * down},
             {elbow + g.forearm_m * along_forearm, forearm * down}}};
}

/// Velocity and angular velocity (in the body's axes) of a body per unit of a joint's rate.
struct Twist {
    Vector3 velocity{Vector3::Zero()};
    Vector3 turning{Vector3::Zero()};
};

Twist twist(const DeviceDescription &device, const Vector3 &q, std::size_t body, int joint) {
    const auto at = [&](double t) { return placed(device, q + t * Vector3::Unit(joint))[body]; };
    const Matrix3 axes_rate = derivative([&](double t) -> Matrix3 { return at(t).axes; });
    const Matrix3 turning = at(0.0).axes.transpose() * axes_rate;
    return {derivative([&](double t) -> Vector3 { return at(t).centre_m; }),
            {turning(2, 1), turning(0, 2), turning(1, 0)}};
}

/// The mass matrix from the kinetic energy of all bodies in space.
Matrix3 mass_matrix_of_bodies(const DeviceDescription &device, const Vector3 &q) {
    const std::array<Body, kBodies> all = bodies(device);
    Matrix3 M = Matrix3::Zero();
    M(0, 0) = device.inertia.base_kg_m2;
    for (std::size_t body = 0; body < kBodies; ++body) {
        const std::array<Twist, 3> by{twist(device, q, body, 0), twist(device, q, body, 1),
                                      twist(device, q, body, 2)};
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column) {
                const Twist &a = by[static_cast<std::size_t>(row)];
                const Twist &b = by[static_cast<std::size_t>(column)];
                M(row, column) += all[body].carried_kg * a.velocity.dot(b.velocity) +
                                  a.turning.dot(all[body].inertia_kg_m2.cwiseProduct(b.turning));
            }
        }
    }
    return M;
}

class Dynamics : public ::testing::TestWithParam<DeviceDescription> {
protected:
    [[nodiscard]] Vector3 any_angles() {
        return testing::random_workspace_angles(GetParam(), random);
    }
    [[nodiscard]] Vector3 any_vector() { return testing::random_vector(random, 1.0); }

    std::mt19937_64 random{41};
    LinkageMoments moments = linkage_moments(GetParam().geometry, GetParam().inertia, kTipLoad_kg);
};

TEST_P(Dynamics, MassMatrixIsSymmetricAndPositiveDefiniteOverTheWorkspace) {
    for (int i = 0; i < 1000; ++i) {
        const Matrix3 M = mass_matrix(moments, any_angles());
        ASSERT_EQ(M, M.transpose());
        ASSERT_EQ(Eigen::LLT<Matrix3>(M).info(), Eigen::Success);
    }
}

TEST_P(Dynamics, MassMatrixIsThatOfTheBodiesInSpace) {
    for (int i = 0; i < 1000; ++i) {
        const Vector3 q = any_angles();
        const Matrix3 M = mass_matrix(moments, q);
        ASSERT_LT((M - mass_matrix_of_bodies(GetParam(), q)).norm(), kDerivative * M.norm());
    }
}

TEST_P(Dynamics, GravityIsTheWeightOfTheBodiesInSpace) {
    const auto weight_J = [](const Vector3 &q) {
        double sum = 0.0;
        for (std::size_t body = 0; body < kBodies; ++body) {
            sum += kGravity_m_per_s2 * bodies(GetParam())[body].mass_kg *
                   placed(GetParam(), q)[body].centre_m.y();
        }
        return sum;
    };
    for (int i = 0; i < 1000; ++i) {
        const Vector3 q = any_angles();
        ASSERT_NEAR(gravity_energy_J(moments, q), weight_J(q), kRoundOff);
        for (int joint = 0; joint < 3; ++joint) {
            const double slope =
                derivative([&](double t) { return weight_J(q + t * Vector3::Unit(joint)); });
            ASSERT_NEAR(gravity_torque_Nm(moments, q)[joint], slope, kDerivative);
        }
    }
}

TEST_P(Dynamics, CoriolisTorquesFollowFromLagrangesEquations) {
    // C q̇ = Ṁ q̇ − ½ ∂(q̇ᵀ M q̇)/∂q, with every derivative by differences of M.
    for (int i = 0; i < 1000; ++i) {
        const Vector3 q = any_angles();
        const Vector3 w = any_vector();
        const Matrix3 M_rate =
            derivative([&](double t) -> Matrix3 { return mass_matrix(moments, q + t * w); });
        Vector3 expected = M_rate * w;
        for (int joint = 0; joint < 3; ++joint) {
            expected[joint] -=
                0.5 * derivative([&](double t) {
                    return w.dot(mass_matrix(moments, q + t * Vector3::Unit(joint)) * w);
                });
        }
        const double scale = mass_matrix(moments, q).norm();
        ASSERT_LT((coriolis_torque_Nm(moments, q, w) - expected).norm(), kDerivative * scale);
    }
}

TEST_P(Dynamics, CoriolisTorquesDoNoWork) {
    // q̇ᵀ(½ Ṁ − C) q̇ = 0; ½ Ṁ, exactly, from the secant with coinciding ends.
    for (int i = 0; i < 1000; ++i) {
        const Vector3 q = any_angles();
        const Vector3 w = any_vector();
        const double scale = mass_matrix(moments, q).norm() * w.norm();
        const double from_inertia = w.dot(inertia_secant(moments, q, q, w) * w);
        ASSERT_NEAR(w.dot(coriolis_torque_Nm(moments, q, w)), from_inertia, kRoundOff * scale);
    }
}

INSTANTIATE_TEST_SUITE_P(Devices, Dynamics,
                         ::testing::Values(testing::phantom_1_0(), testing::phantom_premium_1_5()),
                         [](const auto &instance) {
                             return instance.param.geometry.upper_arm_m < 0.2 ? "Phantom10"
                                                                              : "Premium15";
                         });

/// The equations published by Çavuşoğlu, Feygin and Tendick 2002 for the Premium 1.5, in their
/// notation: a forearm, c rod, be upper arm with motor, df crank with motor. Below, a[1] is I_ayy.
struct Published {
    double l1 = 0.215, l2 = 0.170, l3 = 0.0325, l5 = -0.0368, l6 = 0.0527;
    double ma = 0.0202, mc = 0.0249, mbe = 0.2359, mdf = 0.1906;
    Vector3 a{0.4864e-4, 0.001843e-4, 0.4864e-4};
    Vector3 c{0.959e-4, 0.959e-4, 0.0051e-4};
    Vector3 be{11.09e-4, 10.06e-4, 0.591e-4};
    Vector3 df{7.11e-4, 0.629e-4, 6.246e-4};
    double base_yy = 11.87e-4;

    [[nodiscard]] Matrix3 mass_matrix(double q2, double q3) const {
        const double steady = 4.0 * (a[1] + a[2] + be[1] + be[2] + c[1] + c[2] + df[1] + df[2]) +
                              8.0 * base_yy + 4.0 * l1 * l1 * ma + l2 * l2 * ma + l1 * l1 * mc +
                              4.0 * l3 * l3 * mc;
        const double by_q2 = 4.0 * (be[1] - be[2] + c[1] - c[2]) + l1 * l1 * (4.0 * ma + mc);
        const double by_q3 =
            4.0 * (a[1] - a[2] + df[1] - df[2]) - l2 * l2 * ma - 4.0 * l3 * l3 * mc;
        Matrix3 M = Matrix3::Zero();
        M(0, 0) = (steady + by_q2 * std::cos(2.0 * q2) + by_q3 * std::cos(2.0 * q3)) / 8.0 +
                  l1 * (l2 * ma + l3 * mc) * std::cos(q2) * std::sin(q3);
        M(1, 1) = (4.0 * (be[0] + c[0] + l1 * l1 * ma) + l1 * l1 * mc) / 4.0;
        M(1, 2) = M(2, 1) = -0.5 * l1 * (l2 * ma + l3 * mc) * std::sin(q2 - q3);
        M(2, 2) = (4.0 * (a[0] + df[0]) + l2 * l2 * ma + 4.0 * l3 * l3 * mc) / 4.0;
        return M;
    }

    [[nodiscard]] Vector3 gravity_Nm(double q2, double q3) const {
        const double g = kGravity_m_per_s2;
        return {0.0, 0.5 * g * (2.0 * l1 * ma + 2.0 * l5 * mbe + l1 * mc) * std::cos(q2),
                0.5 * g * (l2 * ma + 2.0 * l3 * mc - 2.0 * l6 * mdf) * std::sin(q3)};
    }
};

TEST(DynamicsOfThePremium15, AreThosePublished) {
    const DeviceDescription device = testing::phantom_premium_1_5();
    const LinkageMoments moments = linkage_moments(device.geometry, device.inertia, 0.0);
    const Published published;
    std::mt19937_64 random(42);
    for (int i = 0; i < 1000; ++i) {
        const Vector3 q = testing::random_workspace_angles(device, random);
        const Matrix3 M = published.mass_matrix(q[1], q[2]);
        ASSERT_LT((mass_matrix(moments, q) - M).norm(), kRoundOff * M.norm());
        ASSERT_LT((gravity_torque_Nm(moments, q) - published.gravity_Nm(q[1], q[2])).norm(),
                  kRoundOff);
    }
}

/// The tip's apparent mass, as a hand feels it that guides the tip along x, y or z: the diagonal of
/// J⁻ᵀ (M + N² J_m) J⁻¹ [g].
Vector3 apparent_mass_g(const DeviceDescription &device, const Vector3 &q_rad) {
    Matrix3 M = mass_matrix(linkage_moments(device.geometry, device.inertia, 0.0), q_rad);
    for (Eigen::Index j = 0; j < 3; ++j) {
        const double N = device.geometry.transmission_ratio[j];
        M(j, j) += N * N * device.motor[static_cast<std::size_t>(j)].rotor_inertia_kg_m2;
    }
    const Matrix3 J_inverse = joint_jacobian(device.geometry, q_rad).inverse();
    return 1e3 * (J_inverse.transpose() * M * J_inverse).diagonal();
}

void expect_within_half_a_gram(const Vector3 &found_g, const Vector3 &stated_g, const char *where) {
    std::printf("%s: x %.1f g, y %.1f g, z %.1f g\n", where, found_g.x(), found_g.y(), found_g.z());
    EXPECT_LT((found_g - stated_g).cwiseAbs().maxCoeff(), 0.5) << where;
}

/// The figures of docs/plant.md: the data sheet's 75 g hold in some directions and places only.
TEST(ApparentMass, OfThePhantom10DependsOnDirectionAndPlace) {
    const DeviceDescription device = testing::phantom_1_0();
    expect_within_half_a_gram(apparent_mass_g(device, Vector3::Zero()), {81.0, 52.6, 37.3},
                              "zero pose");
    expect_within_half_a_gram(apparent_mass_g(device, default_pose_rad()), {157.3, 74.1, 50.3},
                              "default pose");
    constexpr double kShare = 0.6; // of the workspace, within reach
    constexpr int kPoints = 9;
    Vector3 min_g = Vector3::Constant(HUGE_VAL);
    Vector3 greatest_g = Vector3::Zero();
    for (int i = 0; i < kPoints * kPoints * kPoints; ++i) {
        const int row = i / kPoints % kPoints;
        const int layer = i / kPoints / kPoints;
        const Vector3 place(i % kPoints, row, layer);
        const Vector3 share = place / (kPoints - 1) - Vector3::Constant(0.5);
        const std::optional<Vector3> q_rad = joint_angles_rad(
            device.geometry,
            device.workspace.centre_m + kShare * share.cwiseProduct(device.workspace.size_m));
        ASSERT_TRUE(q_rad);
        const Vector3 mass_g = apparent_mass_g(device, *q_rad);
        min_g = min_g.cwiseMin(mass_g);
        greatest_g = greatest_g.cwiseMax(mass_g);
    }
    expect_within_half_a_gram(min_g, {47.5, 49.4, 33.8}, "least within 60 % of the workspace");
    expect_within_half_a_gram(greatest_g, {200.6, 116.4, 73.3}, "greatest");
}

} // namespace
} // namespace springdrive::device
