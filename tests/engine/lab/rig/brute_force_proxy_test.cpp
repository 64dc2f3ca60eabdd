// Covers engine/lab/rig/brute_force_proxy.cpp and plain_triangles.cpp.
#include "engine/lab/rig/brute_force_proxy.h"

#include "tests/engine/contact/proxy/optimality.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace springdrive::rig {
namespace {

using testing::random_direction;
using testing::random_vector;

constexpr double kReach_m = 1e-8;

std::vector<PlainTriangle> two_sided(const contact::TriangleSoup &soup) {
    std::vector<contact::FacetSource> facets;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        facets.push_back(
            {testing::corners(soup, i), contact::FacetSides::two, static_cast<unsigned>(i)});
    }
    return plain_triangles(facets);
}

TEST(PlainTriangle, KnowsItsDistance) {
    std::mt19937_64 random(1);
    for (int i = 0; i < 3000; ++i) {
        const testing::Corners corners{random_vector(random, 0.03), random_vector(random, 0.03),
                                       random_vector(random, 0.03)};
        const PlainTriangle triangle = plain_triangles({{corners, contact::FacetSides::two, 0}})[0];
        const Vector3 point = random_vector(random, 0.05);
        const Away away = triangle.away(point);
        EXPECT_NEAR(away.distance_m, testing::distance_to_triangle(corners, point), 1e-15);
        EXPECT_NEAR(away.direction.norm(), 1.0, 1e-14);
        // What lies there is a point of the triangle.
        const Vector3 nearest = point - away.distance_m * away.direction;
        EXPECT_LT(testing::distance_to_triangle(corners, nearest), 1e-15);
    }
}

TEST(UnopposedPart, IsTheProjectionOntoTheCone) {
    std::mt19937_64 random(2);
    std::array<int, 4> held{};
    for (int i = 0; i < 3000; ++i) {
        std::vector<Vector3> pushes;
        const std::size_t count = random() % 8;
        // About an axis, so that a cone remains open.
        const Vector3 axis = random_direction(random);
        for (std::size_t k = 0; k < count; ++k) {
            pushes.push_back((axis + 0.9 * random_direction(random)).normalized());
        }
        const Vector3 desired = random_direction(random);
        const Vector3 way = unopposed_part(desired, pushes);
        std::size_t active = 0;
        for (const Vector3 &push : pushes) {
            ASSERT_GE(push.dot(way), -1.01e-7 * way.norm());
            active += std::abs(push.dot(way)) < 1e-12 ? 1 : 0;
        }
        // Moreau: what is left of the wish is square to the way, and opposed by all of the cone.
        ASSERT_NEAR((desired - way).dot(way), 0.0, 1e-9);
        for (int k = 0; k < 20; ++k) {
            const Vector3 other = (axis + random_direction(random)).normalized();
            if (std::ranges::all_of(pushes, [&](const Vector3 &p) { return p.dot(other) >= 0; })) {
                ASSERT_LT((desired - way).dot(other), 1e-6);
            }
        }
        ++held[way.norm() == 0.0 ? 3 : std::min<std::size_t>(active, 2)];
    }
    for (const int cases : held) {
        EXPECT_GT(cases, 100); // not vacuous: free, on a face, on an edge, at the tip
    }
}

TEST(BruteForceProxy, GoesToTheFootOnASheet) {
    const std::vector<PlainTriangle> triangles = two_sided(testing::sheet(20, 0.02));
    const BruteForceProxy brute_force(triangles);
    std::mt19937_64 random(3);
    for (int i = 0; i < 30; ++i) {
        Vector3 from = random_vector(random, 0.01);
        Vector3 tip = random_vector(random, 0.01);
        from.y() = kReach_m;
        tip.y() = -1e-3;
        const BruteForceProxy::End end = brute_force.walk(from, tip, kReach_m);
        EXPECT_TRUE(end.is_lowest);
        EXPECT_LT((end.point_m - Vector3(tip.x(), kReach_m, tip.z())).norm(), 3e-9);
    }
}

TEST(BruteForceProxy, IsNotHeldByEdgesOfAFlatSheet) {
    // Right above an edge, and a little before it, where the rim beyond lies as near as the plane.
    const std::vector<PlainTriangle> triangles = two_sided(testing::sheet(20, 0.02));
    const BruteForceProxy brute_force(triangles);
    for (const double before_m : {0.0, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8}) {
        for (const double towards : {-1.0, 1.0}) {
            const Vector3 from(0.002 + before_m, kReach_m, 0.0007);
            const Vector3 tip(0.002 + 1e-3 * towards, -1e-3, 0.0007);
            const BruteForceProxy::End end = brute_force.walk(from, tip, kReach_m);
            EXPECT_TRUE(end.is_lowest);
            EXPECT_NEAR(end.point_m.x(), tip.x(), 2e-9) << before_m;
        }
    }
}

TEST(BruteForceProxy, StaysWhereItIsLowest) {
    const std::vector<PlainTriangle> triangles = two_sided(testing::sheet(20, 0.02));
    const BruteForceProxy brute_force(triangles);
    const Vector3 rest(0.0012, kReach_m, -0.0034);
    const BruteForceProxy::End end = brute_force.walk(rest, rest - Vector3(0, 2e-3, 0), kReach_m);
    EXPECT_TRUE(end.is_lowest);
    EXPECT_EQ(end.point_m, rest);
}

TEST(BruteForceProxy, EndsWhereNothingNearerIsLeftAmongTrianglesWithoutOrder) {
    std::mt19937_64 random(4);
    int touching = 0;
    int wedged = 0;
    for (int mesh = 0; mesh < 60; ++mesh) {
        const contact::TriangleSoup soup = testing::random_soup(random, 200, 0.01, 0.006);
        const std::vector<PlainTriangle> triangles = two_sided(soup);
        const BruteForceProxy brute_force(triangles);
        const Vector3 from = random_vector(random, 0.012);
        const Vector3 tip = random_vector(random, 0.012);
        if (testing::distance_to_soup(soup, from) < kReach_m) {
            continue;
        }
        const BruteForceProxy::End end = brute_force.walk(from, tip, kReach_m);
        ASSERT_TRUE(end.is_lowest) << mesh;
        ASSERT_LE((end.point_m - tip).norm(), (from - tip).norm());
        const Vector3 gap = end.point_m - tip;
        if (gap.norm() < 1e-8) {
            continue;
        }
        ++touching;
        const std::vector<Vector3> pushes = testing::pushes(soup, end.point_m, kReach_m, 2e-10);
        wedged += pushes.size() > 1 ? 1 : 0;
        // What it stops for, and as much again for the pushes' round-off.
        ASSERT_LT(testing::unexplained_m(gap, pushes), 1e-9 + 4e-7 * gap.norm()) << mesh;
        ASSERT_GT(testing::distance_to_soup(soup, end.point_m), kReach_m - 1e-10) << mesh;
    }
    EXPECT_GT(touching, 25);
    EXPECT_GT(wedged, 8);
}

TEST(BruteForceProxy, TakesOneSidedTrianglesFromTheirFrontOnly) {
    std::vector<PlainTriangle> triangles = two_sided(testing::sheet(2, 0.02));
    for (PlainTriangle &triangle : triangles) {
        triangle.two_sided = false;
    }
    const BruteForceProxy brute_force(triangles);
    const Vector3 above(0.001, 2e-3, 0.002);
    const Vector3 below(0.001, -2e-3, 0.002);
    EXPECT_NEAR(brute_force.walk(above, below, kReach_m).point_m.y(), kReach_m, 1e-11);
    EXPECT_LT((brute_force.walk(below, above, kReach_m).point_m - above).norm(), 2e-9);
}

TEST(BruteForceProxy, KeepsARadiusFromAnEdge) {
    // Off the rim of a sheet the offset is round: the tip's nearest place lies straight out.
    const std::vector<PlainTriangle> triangles = two_sided(testing::sheet(4, 0.02));
    const BruteForceProxy brute_force(triangles);
    const double radius_m = 3e-3;
    const Vector3 rim(0.02, 0.0, 0.001);
    const Vector3 tip = rim + 1e-3 * Vector3(1, 2, 0).normalized();
    const Vector3 from = rim + radius_m * Vector3(0, 1, 0);
    const BruteForceProxy::End end = brute_force.walk(from, tip, radius_m);
    EXPECT_TRUE(end.is_lowest);
    EXPECT_LT((end.point_m - (rim + radius_m * Vector3(1, 2, 0).normalized())).norm(), 1e-7);
}

TEST(BruteForceProxy, IsHeldByRidgesHigherThanTheSlack) {
    // A thin rib across a sheet: a triangle that stands up out of it by `height_m`. Rounded by the
    // reach, its slope is 0.014 or more, and the tip pulls across it at 0.005.
    for (const double height_m : {1e-12, 1e-11, 1e-10, 1e-7}) {
        for (const double slack_m : {kMinSlack_m, 3e-11, 1e-9}) {
            contact::TriangleSoup soup = testing::sheet(4, 0.02);
            testing::add_triangle(soup,
                                  {Vector3(0.003, height_m, -0.01), Vector3(0.003, height_m, 0.01),
                                   Vector3(0.003, -0.001, 0)});
            const std::vector<PlainTriangle> triangles = two_sided(soup);
            const BruteForceProxy brute_force(triangles, {}, slack_m);
            const Vector3 from(0.002, kReach_m, 0.001);
            const Vector3 tip(0.003005, -1e-3, 0.001);
            const BruteForceProxy::End end = brute_force.walk(from, tip, kReach_m);
            EXPECT_TRUE(end.is_lowest);
            if (height_m < slack_m) {
                EXPECT_NEAR(end.point_m.x(), 0.003005, 3e-9) << height_m << ' ' << slack_m;
            } else if (height_m > 2.0 * slack_m) {
                EXPECT_LT(end.point_m.x(), 0.003) << height_m << ' ' << slack_m;
            }
        }
    }
}

TEST(BruteForceProxy, KnowsShapes) {
    const std::vector<contact::AnalyticShape> shapes{
        contact::AnalyticShape(contact::Sphere{0.05}, Eigen::Isometry3d::Identity(), 0)};
    const BruteForceProxy brute_force({}, shapes);
    std::mt19937_64 random(5);
    for (int i = 0; i < 20; ++i) {
        const Vector3 towards = random_direction(random);
        const Vector3 from =
            (0.05 + kReach_m) * (towards + 0.2 * random_direction(random)).normalized();
        const BruteForceProxy::End end = brute_force.walk(from, 0.045 * towards, kReach_m);
        EXPECT_TRUE(end.is_lowest);
        EXPECT_LT((end.point_m - (0.05 + kReach_m) * towards).norm(), 2e-8); // 0.2 µrad, and 1 nm
    }
}

} // namespace
} // namespace springdrive::rig
