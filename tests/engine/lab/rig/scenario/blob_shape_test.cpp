// Covers engine/lab/rig/scenario/blob_shape.cpp.
#include "engine/lab/rig/scenario/blob_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace springdrive::rig {
namespace {

TEST(BlobShape, OfOneBlobIsASphere) {
    // (1 − r²)³ = 1/8 at r² = 1/2.
    const BlobShape shape{{{Vector3::Zero(), 1.0}}, 0.125};
    const Vector3 direction = Vector3(1.0, -2.0, 0.5).normalized();
    EXPECT_NEAR(shape.distance(direction), std::sqrt(0.5), 1e-15);
    EXPECT_NEAR((shape.outward_normal(0.7 * direction) - direction).norm(), 0.0, 1e-15);
    EXPECT_EQ(shape.field(1.01 * direction), 0.0);
}

TEST(BlobShape, OrganicSurfaceIsOnItsLevelWithTheNormalOfItsField) {
    const BlobShape &shape = organic_shape();
    std::mt19937_64 random(2);
    std::normal_distribution<double> coordinate;
    for (int i = 0; i < 500; ++i) {
        const double x = coordinate(random);
        const double y = coordinate(random);
        const Vector3 direction = Vector3(x, y, coordinate(random)).normalized();
        const Vector3 point = shape.distance(direction) * direction;
        ASSERT_NEAR(shape.field(point), shape.level, 1e-13);
        // Central differences.
        constexpr double kStep = 1e-5;
        Vector3 descent;
        for (int axis = 0; axis < 3; ++axis) {
            const Vector3 step = kStep * Vector3::Unit(axis);
            descent[axis] = (shape.field(point - step) - shape.field(point + step)) / (2.0 * kStep);
        }
        ASSERT_LT((descent.normalized() - shape.outward_normal(point)).norm(), 1e-6);
    }
}

} // namespace
} // namespace springdrive::rig
