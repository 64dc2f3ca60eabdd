// Covers device/simulated/friction.h.
#include "device/simulated/friction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace springdrive::simulated {
namespace {

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
