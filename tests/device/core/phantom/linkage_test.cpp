// Covers device/core/phantom/kinematics.cpp and dynamics.cpp, the latter also against CVODE, and
// its secants, the basis of the plant's exact energy.
#include "device/core/phantom/kinematics.h"

#include "base/degrees.h"
#include "device/core/phantom/dynamics.h"
#include "tests/support/configurations.h"
#include "tests/support/cvode.h"
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

/// Joint angles well inside the branch of `joint_angles_rad`.
Vector3 random_configuration(std::mt19937_64 &random) {
    std::uniform_real_distribution<double> angle(-1.0, 1.0);
    const double q2 = 0.9 * angle(random);
    return {1.2 * angle(random), q2, q2 + 80.0 * kRadiansPerDegree * angle(random)};
}

bool is_on_the_branch(const PhantomGeometry &g, const Vector3 &q) {
    return g.upper_arm_m * std::cos(q[1]) + g.forearm_m * std::sin(q[2]) > 0.01;
}

class Kinematics : public ::testing::TestWithParam<DeviceDescription> {
protected:
    [[nodiscard]] const PhantomGeometry &geometry() const { return GetParam().geometry; }
};

TEST_P(Kinematics, ZeroPoseHasItsTipAtTheOrigin) {
    EXPECT_EQ(tip_position_m(geometry(), Vector3::Zero()), Vector3::Zero());
}

TEST_P(Kinematics, JacobiansAgreeWithFiniteDifferencesOverTheWorkspace) {
    std::mt19937_64 random(1);
    // Central differences of positions of about l: the sum of round-off ε l/h and truncation h² l/6
    // is smallest at h = (3ε)^(1/3) = 7e-6, about 2e-11 l each.
    constexpr double kStep = 7e-6;
    constexpr double kRelative = 1e-9;
    for (int i = 0; i < 1000; ++i) {
        const Vector3 q = testing::random_workspace_angles(GetParam(), random);
        const Matrix3 jacobian = joint_jacobian(geometry(), q);
        const Matrix3 motor = motor_jacobian(geometry(), q);
        for (int joint = 0; joint < 3; ++joint) {
            const Vector3 step = kStep * Vector3::Unit(joint);
            const Vector3 difference =
                (tip_position_m(geometry(), q + step) - tip_position_m(geometry(), q - step)) /
                (2.0 * kStep);
            const double tolerance = kRelative * difference.norm();
            ASSERT_LT((jacobian.col(joint) - difference).norm(), tolerance);
            ASSERT_LT((motor.col(joint) * geometry().transmission_ratio[joint] - difference).norm(),
                      tolerance);
        }
    }
}

TEST_P(Kinematics, JacobianRateAgreesWithFiniteDifferencesOverTheWorkspace) {
    std::mt19937_64 random(2);
    constexpr double kFastest_rad_per_s = 3.0;
    // As above, for a motion whose fastest term turns at up to 3·3 rad/s.
    constexpr double kDifference_s = 1e-6;
    for (int i = 0; i < 1000; ++i) {
        const Vector3 q = testing::random_workspace_angles(GetParam(), random);
        const Vector3 w = testing::random_vector(random, kFastest_rad_per_s);
        const Matrix3 difference = (joint_jacobian(geometry(), q + kDifference_s * w) -
                                    joint_jacobian(geometry(), q - kDifference_s * w)) /
                                   (2.0 * kDifference_s);
        ASSERT_LT((joint_jacobian_rate(geometry(), q, w) - difference).norm(),
                  1e-9 * joint_jacobian(geometry(), q).norm() * kFastest_rad_per_s);
    }
}

TEST_P(Kinematics, JacobiansHoldOutsideTheWorkspaceToo) {
    // Near the ends of the branch, links up to 80° from perpendicular, and behind the base axis.
    std::mt19937_64 random(5);
    constexpr double kStep = 7e-6;
    for (int i = 0; i < 1000; ++i) {
        const Vector3 q = random_configuration(random);
        const Vector3 w = testing::random_vector(random, 1.0);
        const Vector3 difference = (tip_position_m(geometry(), q + kStep * w) -
                                    tip_position_m(geometry(), q - kStep * w)) /
                                   (2.0 * kStep);
        ASSERT_LT((joint_jacobian(geometry(), q) * w - difference).norm(), 1e-9);
    }
}

TEST_P(Kinematics, InverseUndoesForward) {
    std::mt19937_64 random(3);
    int tried = 0;
    for (int i = 0; i < 1000; ++i) {
        const Vector3 q = random_configuration(random);
        if (!is_on_the_branch(geometry(), q)) {
            continue;
        }
        ++tried;
        const std::optional<Vector3> back =
            joint_angles_rad(geometry(), tip_position_m(geometry(), q));
        ASSERT_TRUE(back.has_value());
        // The arc sine at 80° of elbow loses a factor 1/cos 80° ≈ 6 of the round-off.
        ASSERT_LT((*back - q).norm(), 1e-12);
    }
    EXPECT_GT(tried, 500);
}

TEST_P(Kinematics, PointsOutOfReachHaveNoAngles) {
    const double reach = geometry().upper_arm_m + geometry().forearm_m;
    const Vector3 shoulder(0.0, geometry().forearm_m, -geometry().upper_arm_m);
    const Vector3 forward = Vector3::UnitZ();
    EXPECT_TRUE(joint_angles_rad(geometry(), shoulder + 0.999 * reach * forward).has_value());
    EXPECT_FALSE(joint_angles_rad(geometry(), shoulder + 1.001 * reach * forward).has_value());
    EXPECT_FALSE(joint_angles_rad(geometry(), Vector3(NAN, 0.0, 0.0)).has_value());
    EXPECT_FALSE(joint_angles_rad(geometry(), Vector3(INFINITY, 0.0, 0.0)).has_value());
}

TEST_P(Kinematics, TheDrawnLinkageIsRigidAndEndsAtTheTip) {
    std::mt19937_64 random(4);
    for (int i = 0; i < 200; ++i) {
        const Vector3 q = random_configuration(random);
        const LinkagePose pose = linkage_pose(geometry(), q);
        ASSERT_LT((pose.tip_m - tip_position_m(geometry(), q)).norm(), 1e-15);
        ASSERT_NEAR((pose.elbow_m - pose.base_m).norm(), geometry().upper_arm_m, 1e-15);
        ASSERT_NEAR((pose.tip_m - pose.elbow_m).norm(), geometry().forearm_m, 1e-15);
        // A parallelogram: the rod is as long as the upper arm and parallel to it.
        ASSERT_LT(((pose.coupling_m - pose.crank_m) - (pose.elbow_m - pose.base_m)).norm(), 1e-15);
        ASSERT_NEAR((pose.crank_m - pose.base_m).norm(), geometry().crank_m, 1e-15);
    }
}

INSTANTIATE_TEST_SUITE_P(Devices, Kinematics,
                         ::testing::Values(testing::phantom_1_0(), testing::phantom_premium_1_5()),
                         [](const auto &instance) {
                             return instance.param.geometry.upper_arm_m < 0.2 ? "Phantom10"
                                                                              : "Premium15";
                         });

TEST(TipPlace, IsPositionAndJacobianInOne) {
    const PhantomGeometry geometry = testing::phantom_1_0().geometry;
    const Vector3 q_rad(0.3, 0.2, -0.1);
    const TipPlace place = tip_place(geometry, q_rad);
    EXPECT_EQ(place.tip_m, tip_position_m(geometry, q_rad));
    EXPECT_EQ(place.jacobian_m_per_rad, joint_jacobian(geometry, q_rad));
}

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

using Eigen::VectorXd;

TEST(Cvode, IsAccurateEnoughAsAReference) {
    // A pendulum's closed form would need elliptic functions; ẏ = −y² has y = 1/(1 + t), and an
    // oscillator of 100 rad/s its sine. A hundred radians of steps at 1e-12 each.
    const VectorXd end = testing::integrate(
        [](double, const VectorXd &y) -> VectorXd {
            return Vector3(-y[0] * y[0], y[2], -1e4 * y[1]);
        },
        Vector3(1.0, 0.0, 100.0), 1.0);
    EXPECT_NEAR(end[0], 0.5, 1e-11);
    EXPECT_NEAR(end[1], std::sin(100.0), 1e-9);
}

/// Torques at the joints, smooth and different on each.
struct RandomTorques {
    explicit RandomTorques(std::mt19937_64 &random) {
        for (int j = 0; j < 3; ++j) {
            amplitude_Nm.col(j) = testing::random_vector(random, 0.05);
            frequency.col(j) = testing::random_vector(random, 40.0);
        }
    }
    [[nodiscard]] Vector3 at(double time_s) const {
        return (amplitude_Nm.array() * (frequency.array() * time_s).sin()).matrix().rowwise().sum();
    }

    Matrix3 amplitude_Nm{Matrix3::Zero()};
    Matrix3 frequency{Matrix3::Zero()}; ///< rad/s
};

TEST(DynamicsAgainstCvode, EnergyGrowsByTheWorkOfTheTorques) {
    // M q̈ + C q̇ + g = τ(t) together with Ẇ = τᵀ q̇: they agree only if the equations share one
    // energy.
    std::mt19937_64 random(61);
    for (int run = 0; run < 20; ++run) {
        const DeviceDescription device =
            run % 2 == 0 ? testing::phantom_1_0() : testing::phantom_premium_1_5();
        const LinkageMoments m = linkage_moments(device.geometry, device.inertia, 0.05);
        const RandomTorques torques(random);
        const auto rates = [&](double time_s, const VectorXd &y) {
            const Vector3 q = y.head<3>();
            const Vector3 w = y.segment<3>(3);
            const Vector3 torque_Nm = torques.at(time_s);
            VectorXd y_rate(7);
            y_rate << w,
                mass_matrix(m, q).inverse() *
                    (torque_Nm - coriolis_torque_Nm(m, q, w) - gravity_torque_Nm(m, q)),
                torque_Nm.dot(w);
            return y_rate;
        };
        const auto energy_J = [&](const VectorXd &y) {
            const Vector3 w = y.segment<3>(3);
            return 0.5 * w.dot(mass_matrix(m, y.head<3>()) * w) + gravity_energy_J(m, y.head<3>());
        };
        VectorXd start(7);
        start << testing::random_workspace_angles(device, random),
            testing::random_vector(random, 2.0), 0.0;
        const VectorXd end = testing::integrate(rates, start, 0.5);
        const double work_J = end[6];
        ASSERT_GT(std::abs(work_J), 1e-4); // not vacuous
        EXPECT_NEAR((energy_J(end) - energy_J(start)) / work_J, 1.0, 1e-8) << "run " << run;
    }
}

} // namespace
} // namespace springdrive::device
