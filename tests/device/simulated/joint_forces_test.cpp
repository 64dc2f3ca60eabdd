// Covers device/simulated/friction.cpp and the joints' stops of linkage_step.cpp.
#include "device/simulated/friction.h"

#include "device/simulated/linkage_step.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace springdrive::simulated {
namespace {

using Modes = std::array<FrictionMode, 3>;

constexpr std::array<FrictionMode, 3> kModes{FrictionMode::stopped, FrictionMode::turning_forward,
                                             FrictionMode::turning_backward};

/// A v = b + f with f in its range and a solution of order 1.
struct Problem {
    Matrix3 A{Matrix3::Identity()};
    Vector3 b{Vector3::Zero()};
    FrictionRange friction;
};

/// @param skew  the skew part of A, which does no work, as in the inertia's secant
Problem random_problem(std::mt19937_64 &random, double skew) {
    Matrix3 root;
    root << testing::random_vector(random, 1.0), testing::random_vector(random, 1.0),
        testing::random_vector(random, 1.0);
    const Vector3 w = testing::random_vector(random, skew);
    Matrix3 without_work;
    without_work << 0.0, -w[2], w[1], w[2], 0.0, -w[0], -w[1], w[0], 0.0;
    Problem problem;
    problem.A = root * root.transpose() + 0.01 * Matrix3::Identity() + without_work;
    problem.b = testing::random_vector(random, 1.0);
    Vector3 rate = testing::random_vector(random, 1.0);
    for (double &one : rate) { // one in three is at rest
        one = std::abs(one) < 1.0 / 3.0 ? 0.0 : one;
    }
    problem.friction = FrictionRange::after(rate, testing::random_vector(random, 1.0).cwiseAbs());
    return problem;
}

/// Whether every joint's friction is consistent with its motion, up to round-off.
bool is_complementary(const Problem &problem, const Vector3 &v, double tolerance) {
    const Vector3 f = problem.A * v - problem.b;
    for (int j = 0; j < 3; ++j) {
        const double minimum = problem.friction.minimum[j];
        const double maximum = problem.friction.maximum[j];
        const bool good = v[j] > tolerance ? std::abs(f[j] - minimum) <= tolerance
                          : v[j] < -tolerance
                              ? std::abs(f[j] - maximum) <= tolerance
                              : f[j] >= minimum - tolerance && f[j] <= maximum + tolerance;
        if (!good) {
            return false;
        }
    }
    return true;
}

/// v for given modes; the rows of stopped joints are vⱼ = 0.
Vector3 solution_for(const Problem &problem, const Modes &modes) {
    Matrix3 system = problem.A;
    Vector3 right = problem.b;
    for (int j = 0; j < 3; ++j) {
        switch (modes[static_cast<std::size_t>(j)]) {
        case FrictionMode::stopped:
            system.row(j) = Vector3::Unit(j).transpose();
            right[j] = 0.0;
            break;
        case FrictionMode::turning_forward:
            right[j] += problem.friction.minimum[j];
            break;
        case FrictionMode::turning_backward:
            right[j] += problem.friction.maximum[j];
            break;
        }
    }
    return system.fullPivLu().solve(right);
}

/// All complementary ones among the 27 combinations; due to round-off there can be more than one.
std::vector<Vector3> brute_force(const Problem &problem, double tolerance) {
    std::vector<Vector3> found;
    for (const FrictionMode first : kModes) {
        for (const FrictionMode second : kModes) {
            for (const FrictionMode third : kModes) {
                const Vector3 v = solution_for(problem, {first, second, third});
                if (is_complementary(problem, v, tolerance)) {
                    found.push_back(v);
                }
            }
        }
    }
    return found;
}

/// Round-off, amplified by the condition of A: its smallest eigenvalue is at least 0.01, its
/// entries are below 4.
constexpr double kTolerance = 1e-12;

class FrictionSolver : public ::testing::TestWithParam<double> {};

TEST_P(FrictionSolver, FindsTheUniqueSolutionFromAnyStart) {
    std::mt19937_64 random(21);
    std::uniform_int_distribution<std::size_t> any(0, 2);
    int stopped = 0;
    for (int i = 0; i < 10'000; ++i) {
        const Problem problem = random_problem(random, GetParam());
        Modes modes{kModes[any(random)], kModes[any(random)], kModes[any(random)]};
        const Vector3 v = solve_with_friction(problem.A, problem.b, problem.friction, modes);
        ASSERT_TRUE(is_complementary(problem, v, kTolerance)) << "problem " << i;
        const std::vector<Vector3> truth = brute_force(problem, kTolerance);
        ASSERT_FALSE(truth.empty());
        for (const Vector3 &one : truth) { // exactly one solution, even if several combinations
                                           // give it
            ASSERT_LT((v - one).norm(), 100.0 * kTolerance * (1.0 + v.norm())) << "problem " << i;
        }
        for (int j = 0; j < 3; ++j) {
            const FrictionMode mode = modes[static_cast<std::size_t>(j)];
            stopped += mode == FrictionMode::stopped ? 1 : 0;
            ASSERT_TRUE(mode != FrictionMode::stopped || v[j] == 0.0); // exactly
        }
    }
    EXPECT_GT(stopped, 3000); // of 30,000 joints
    EXPECT_LT(stopped, 27'000);
}

INSTANTIATE_TEST_SUITE_P(Systems, FrictionSolver, ::testing::Values(0.0, 1.0),
                         [](const auto &instance) {
                             return instance.param == 0.0 ? "Symmetric" : "WithASkewPart";
                         });

TEST(FrictionRange, OnlyOpposesThePreviousMotion) {
    const FrictionRange range =
        FrictionRange::after(Vector3(1e-300, 0.0, -1e-300), Vector3(1.0, 2.0, 3.0));
    EXPECT_EQ(range.minimum, Vector3(-1.0, -2.0, 0.0));
    EXPECT_EQ(range.maximum, Vector3(0.0, 2.0, 3.0));
}

TEST(FrictionSolver, WithoutFrictionIsAPlainSolution) {
    std::mt19937_64 random(22);
    for (int i = 0; i < 100; ++i) {
        Problem problem = random_problem(random, 1.0);
        problem.friction = {};
        Modes modes{};
        const Vector3 v = solve_with_friction(problem.A, problem.b, problem.friction, modes);
        ASSERT_LT((problem.A * v - problem.b).norm(), kTolerance);
    }
}

TEST(FrictionSolver, TwoJointsEqualThreeWithOneDecoupled) {
    std::mt19937_64 random(23);
    for (int i = 0; i < 1000; ++i) {
        Problem problem = random_problem(random, 1.0);
        problem.A.row(0) = problem.A.col(0).transpose() = Vector3::UnitX().transpose();
        const JointFrictionRange<2> friction{problem.friction.minimum.tail<2>(),
                                             problem.friction.maximum.tail<2>()};
        Modes modes{};
        std::array<FrictionMode, 2> two_modes{};
        const Vector3 v = solve_with_friction(problem.A, problem.b, problem.friction, modes);
        const Eigen::Vector2d two_v = solve_with_friction(problem.A.bottomRightCorner<2, 2>(),
                                                          problem.b.tail<2>(), friction, two_modes);
        ASSERT_LT((v.tail<2>() - two_v).norm(), kTolerance * (1.0 + v.norm()));
        ASSERT_EQ(two_modes[0], modes[1]);
        ASSERT_EQ(two_modes[1], modes[2]);
    }
}

const device::JointLimits &limits() {
    static const device::JointLimits read = testing::phantom_1_0().joint_limits;
    return read;
}

/// Angles in and beyond the joints' travel.
Vector3 random_angles(std::mt19937_64 &random) {
    return 0.5 * (limits().min_rad + limits().max_rad) + testing::random_vector(random, 2.5);
}

bool is_inside(const Vector3 &q) {
    const double fold = q[2] - q[1];
    return (q.array() <= limits().max_rad.array()).all() &&
           (q.array() >= limits().min_rad.array()).all() && fold <= limits().max_q3_minus_q2_rad &&
           fold >= limits().min_q3_minus_q2_rad;
}

TEST(JointStops, DoWorkEqualToTheirEnergyChange) {
    std::mt19937_64 random(31);
    int pressed = 0;
    for (int i = 0; i < 10'000; ++i) {
        const Vector3 q_a = random_angles(random);
        // Large and small steps, down to that of a joint at rest.
        const Vector3 q_b = q_a + std::pow(10.0, -(i % 12)) * testing::random_vector(random, 1.0);
        const StopTorque stop = stop_torque(limits(), q_a, q_b);
        const double before_J = stop_energy_J(limits(), q_a);
        const double after_J = stop_energy_J(limits(), q_b);
        pressed += before_J > 0.0 ? 1 : 0;
        // Round-off of energies of up to some hundred joules.
        ASSERT_NEAR(stop.torque_Nm.dot(q_b - q_a), before_J - after_J,
                    1e-14 * (before_J + after_J + 1.0));
        ASSERT_GE(Eigen::SelfAdjointEigenSolver<Matrix3>(stop.damping_Nms_per_rad)
                      .eigenvalues()
                      .minCoeff(),
                  -1e-16);
        ASSERT_TRUE(before_J > 0.0 || stop.damping_Nms_per_rad.isZero(0.0));
    }
    EXPECT_GT(pressed, 1000);
    EXPECT_LT(pressed, 9900);
}

TEST(JointStops, AreInactiveInside) {
    std::mt19937_64 random(32);
    int inside = 0;
    while (inside < 1000) {
        const Vector3 q_a = random_angles(random);
        const Vector3 q_b = random_angles(random);
        if (!is_inside(q_a) || !is_inside(q_b)) {
            continue;
        }
        ++inside;
        const StopTorque stop = stop_torque(limits(), q_a, q_b);
        ASSERT_EQ(stop.torque_Nm, Vector3::Zero());
        ASSERT_EQ(stop.damping_Nms_per_rad, Matrix3::Zero());
        ASSERT_EQ(stop_energy_J(limits(), q_a), 0.0);
    }
}

TEST(JointStops, PressBackBeyondEachOfTheEightLimits) {
    const double fold_rad = 0.5;
    const device::JointLimits box{Vector3::Constant(-1.0), Vector3::Constant(1.0), -fold_rad,
                                  fold_rad};
    struct Line {
        Vector3 at_rad;
        Vector3 outwards;
    };
    const std::array<Line, 8> lines{{
        {Vector3(1.0, 0.0, 0.0), Vector3::UnitX()},
        {Vector3(-1.0, 0.0, 0.0), -Vector3::UnitX()},
        {Vector3(0.0, 1.0, 0.8), Vector3::UnitY()},
        {Vector3(0.0, -1.0, -0.8), -Vector3::UnitY()},
        {Vector3(0.0, 0.8, 1.0), Vector3::UnitZ()},
        {Vector3(0.0, -0.8, -1.0), -Vector3::UnitZ()},
        {Vector3(0.0, 0.0, fold_rad), Vector3(0.0, -1.0, 1.0)},
        {Vector3(0.0, 0.0, -fold_rad), Vector3(0.0, 1.0, -1.0)},
    }};
    constexpr double kBeyond_rad = 1e-6;
    for (const Line &line : lines) {
        const Vector3 out = line.at_rad + kBeyond_rad * line.outwards;
        const Vector3 in = line.at_rad - kBeyond_rad * line.outwards;
        const Vector3 torque_Nm = stop_torque(box, out, out).torque_Nm;
        EXPECT_LT(torque_Nm.dot(line.outwards), 0.0);
        EXPECT_LT(torque_Nm.cross(line.outwards).norm(), 1e-15); // exactly opposed to it
        EXPECT_EQ(stop_torque(box, in, in).torque_Nm, Vector3::Zero());
    }
}

template <int size> void expect_solutions() {
    using Matrix = Eigen::Matrix<double, size, size>;
    using Vector = Eigen::Matrix<double, size, 1>;
    std::mt19937_64 random(31);
    std::uniform_real_distribution<double> one(-1.0, 1.0);
    for (int i = 0; i < 1000; ++i) {
        const Matrix root = Matrix::NullaryExpr([&] { return one(random); });
        const Matrix other = Matrix::NullaryExpr([&] { return one(random); });
        const Vector x = Vector::NullaryExpr([&] { return one(random); });
        // A positive definite part, and a skew part.
        const Matrix A =
            root * root.transpose() + 0.01 * Matrix::Identity() + (other - other.transpose());
        // Condition up to some hundreds, and tens of operations.
        ASSERT_LT((solve_definite<size>(A, A * x) - x).norm(), 1e-11);
    }
}

TEST(SmallSystem, SolvesTwoAndThreeEquations) {
    expect_solutions<2>();
    expect_solutions<3>();
}

TEST(SmallSystem, HasNoFiniteSolutionIfSingular) {
    Eigen::Matrix2d A;
    A << 1.0, 2.0, 2.0, 4.0;
    EXPECT_FALSE(solve_definite<2>(A, Eigen::Vector2d(1.0, 1.0)).allFinite());
}

} // namespace
} // namespace springdrive::simulated
