// Covers engine/contact/mesh/nearest.cpp: against dense sampling of triangles and segments.
#include "engine/contact/mesh/nearest.h"

#include "tests/engine/contact/mesh/soups.h"

#include <gtest/gtest.h>

#include <cmath>

namespace springdrive::contact {
namespace {

using testing::random_vector;

TEST(NearestOnTriangle, IsNearerThanAnySampleAndOnTheTriangle) {
    std::mt19937_64 random(1);
    for (int i = 0; i < 2000; ++i) {
        const testing::Corners triangle = {random_vector(random, 1.0), random_vector(random, 1.0),
                                           random_vector(random, 1.0)};
        const Vector3 query = random_vector(random, 2.0);
        const TrianglePoint nearest = nearest_on_triangle(triangle, query);
        const Vector3 &w = nearest.weights;
        ASSERT_GE(w.minCoeff(), 0.0);
        ASSERT_NEAR(w.sum(), 1.0, 1e-14);
        const Vector3 by_weights = w[0] * triangle[0] + w[1] * triangle[1] + w[2] * triangle[2];
        ASSERT_LT((by_weights - nearest.point_m).norm(), 1e-11);
        const double distance = (query - nearest.point_m).norm();
        ASSERT_NEAR(distance, testing::distance_to_triangle(triangle, query), 1e-11);
        for (int u = 0; u <= 12; ++u) {
            for (int v = 0; u + v <= 12; ++v) {
                const Vector3 sample = triangle[0] + u / 12.0 * (triangle[1] - triangle[0]) +
                                       v / 12.0 * (triangle[2] - triangle[0]);
                ASSERT_LE(distance, (query - sample).norm() + 1e-14);
            }
        }
    }
}

TEST(NearestOnTriangle, IsItsCornerEdgeOrFootWhereTheseAre) {
    const testing::Corners triangle = {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0)};
    EXPECT_EQ(nearest_on_triangle(triangle, {-1, -1, 1}).weights, Vector3(1, 0, 0));
    EXPECT_EQ(nearest_on_triangle(triangle, {0.25, -1, 2}).weights, Vector3(0.75, 0.25, 0));
    EXPECT_EQ(nearest_on_triangle(triangle, {0.25, 0.25, 3}).point_m, Vector3(0.25, 0.25, 0));
}

TEST(SegmentDistance, IsTheMinimumOverAllPairsOfPoints) {
    std::mt19937_64 random(2);
    for (int i = 0; i < 3000; ++i) {
        const Vector3 a = random_vector(random, 1.0);
        const Vector3 c = random_vector(random, 1.0);
        // Also parallel ones, and points.
        const Vector3 b = i % 7 == 0 ? a : Vector3(a + random_vector(random, 1.0));
        const Vector3 d = i % 5 == 0    ? Vector3(c + 0.7 * (b - a))
                          : i % 11 == 0 ? c
                                        : Vector3(c + random_vector(random, 1.0));
        double minimum = INFINITY;
        constexpr int kSamples = 40;
        for (int u = 0; u <= kSamples; ++u) {
            const Vector3 p = a + u * (b - a) / kSamples;
            minimum = std::min(minimum, (d - c).norm() > 0.0 ? testing::distance_to_segment(p, c, d)
                                                             : (p - c).norm());
        }
        const double distance = segment_distance_m(a, b, c, d);
        ASSERT_LE(distance, minimum + 1e-12);
        // Half a sample's step along a–b, at most.
        ASSERT_GE(distance, minimum - 0.5 * (b - a).norm() / kSamples - 1e-12);
    }
}

TEST(SegmentDistance, IsRightFarBelowTheLengthOfTheSegments) {
    // Two that cross, 1e-8 apart: distances that a proxy keeps.
    const double distance = segment_distance_m({-0.1, 0.0, 0.3}, {0.1, 0.0, 0.3},
                                               {0.02, -0.1, 0.3 + 1e-8}, {0.01, 0.1, 0.3 + 1e-8});
    EXPECT_NEAR(distance, 1e-8, 1e-16);
}

} // namespace
} // namespace springdrive::contact
