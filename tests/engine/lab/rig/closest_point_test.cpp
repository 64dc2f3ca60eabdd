// Covers engine/lab/rig/closest_point.cpp.
#include "engine/lab/rig/closest_point.h"

#include "engine/contact/mesh/nearest.h"
#include "engine/lab/rig/scenario/test_surfaces.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace springdrive::rig {
namespace {

double brute_force_m(const contact::TriangleSoup &soup, const Vector3 &to_m) {
    double min_m = std::numeric_limits<double>::infinity();
    for (const auto &[a, b, c] : soup.triangles) {
        const contact::TrianglePoint found = contact::nearest_on_triangle(
            {soup.vertices_m[a], soup.vertices_m[b], soup.vertices_m[c]}, to_m);
        min_m = std::min(min_m, (found.point_m - to_m).norm());
    }
    return min_m;
}

TEST(ClosestPoint, IsThatOfTryingEveryTriangle) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> coordinate(-0.08, 0.08);
    for (const contact::TriangleSoup &soup :
         {icosphere(3, kTestSphereRadius_m), organic_surface(3, kTestOrganicScale_m)}) {
        ClosestPointFinder finder(soup);
        for (int i = 0; i < 300; ++i) { // each far from the last
            const double x = coordinate(random);
            const double y = coordinate(random);
            const Vector3 tip_m(x, y, coordinate(random));
            const ClosestPoint closest = finder.closest(tip_m);
            // Round-off of distances below 0.2 m.
            ASSERT_NEAR((closest.point_m - tip_m).norm(), brute_force_m(soup, tip_m), 1e-15);
            ASSERT_NEAR(closest.normal.norm(), 1.0, 1e-14);
        }
    }
}

TEST(ClosestPoint, NormalPointsOutOfASphere) {
    ClosestPointFinder finder(icosphere(4, 1.0));
    const Vector3 tip_m = 0.95 * Vector3(1.0, 2.0, -2.0).normalized();
    EXPECT_GT(finder.closest(tip_m).normal.dot(tip_m.normalized()), 0.99);
}

} // namespace
} // namespace springdrive::rig
