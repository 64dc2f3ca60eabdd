// Covers engine/lab/rig/brute_force_proxy.cpp and brute_force_proxy.cpp: what the proxy is held
// against.
#include "engine/lab/rig/brute_force_proxy.h"

#include "tests/engine/contact/proxy/optimality.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace springdrive::rig {
namespace {

using contact::FacetSides;
using testing::random_direction;
using testing::random_vector;

constexpr double kReach_m = 1e-8;

std::vector<PlainTriangle> triangles_of(const contact::TriangleSoup &soup,
                                        FacetSides sides = FacetSides::two) {
    std::vector<contact::FacetSource> facets;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        facets.push_back({testing::corners(soup, i), sides, static_cast<unsigned>(i)});
    }
    return plain_triangles(facets);
}

PlainTriangle triangle_of(const testing::Corners &corners, FacetSides sides = FacetSides::two) {
    return plain_triangles({{corners, sides, 0}})[0];
}

testing::Corners random_corners(std::mt19937_64 &random) {
    return {random_vector(random, 0.03), random_vector(random, 0.03), random_vector(random, 0.03)};
}

TEST(PlainTriangle, KnowsItsDistance) {
    std::mt19937_64 random(1);
    for (int i = 0; i < 3000; ++i) {
        const testing::Corners corners = random_corners(random);
        const Vector3 point = random_vector(random, 0.05);
        const Away away = triangle_of(corners).away(point);
        EXPECT_NEAR(away.distance_m, testing::distance_to_triangle(corners, point), 1e-15);
        EXPECT_NEAR(away.direction.norm(), 1.0, 1e-14);
        const Vector3 nearest = point - away.distance_m * away.direction;
        EXPECT_LT(testing::distance_to_triangle(corners, nearest), 1e-15);
    }
}

TEST(PlainTriangle, IsAtLeastHalfAsFarBeyondAsItsDistance) {
    std::mt19937_64 random(6);
    for (int i = 0; i < 30'000; ++i) {
        testing::Corners corners = random_corners(random);
        if (i % 3 > 0) { // a needle, or flat
            const Vector3 side = corners[1] - corners[0];
            corners[2] = corners[i % 3 == 1 ? 0 : 1] + (i % 3 == 1 ? 0.0 : 0.4) * side +
                         random_vector(random, 1e-5);
        }
        const PlainTriangle triangle = triangle_of(corners);
        const Vector3 at = corners[random() % 3] + random_vector(random, i % 2 == 0 ? 1e-7 : 0.05);
        const Vector3 point = at - triangle.height_m(at) * triangle.normal;
        const double distance_m = testing::distance_to_triangle(corners, point);
        // The plane itself is known to this, as its normal is the product of parallel edges.
        const double round_off_m = 11.0 * 1.1e-16 * 0.1 / triangle.sine() + 1e-15;
        EXPECT_LE(triangle.beyond_m(point), distance_m + round_off_m);
        EXPECT_GE(std::max(triangle.beyond_m(point), 0.0), 0.5 * distance_m - round_off_m);
    }
}

TEST(GoesThrough, TellsSidesAndRims) {
    const testing::Corners corners{Vector3(0, 0, 0), Vector3(0, 0, 0.01), Vector3(0.01, 0, 0)};
    constexpr double kHeight_m = 1e-6;
    struct Case {
        FacetSides sides;
        double x_m;
        double from; ///< heights, of kHeight_m
        double to;
        bool crosses;
    };
    for (const Case &one :
         {Case{FacetSides::one, 2e-3, 1, -1, true}, Case{FacetSides::one, 2e-3, -1, 1, false},
          Case{FacetSides::two, 2e-3, -1, 1, true}, Case{FacetSides::two, 2e-3, 1, 0.1, false},
          Case{FacetSides::two, 2e-3, -1, -0.1, false},
          // 0.1 nm beyond the rim along z still counts.
          Case{FacetSides::one, -0.9e-10, 1, -1, true},
          Case{FacetSides::one, -1.1e-10, 1, -1, false}}) {
        const Vector3 from(one.x_m, one.from * kHeight_m, 0.002);
        const Vector3 to(one.x_m, one.to * kHeight_m, 0.002);
        EXPECT_EQ(goes_through(triangle_of(corners, one.sides), from, to), one.crosses)
            << one.x_m << ' ' << one.from << ' ' << one.to;
    }
}

TEST(GoesThrough, IsNotMistakenBesideTheTipOfANeedle) {
    // Beyond the tip both long edges are as near as the needle is thin: 5 pm at 10 nm for 50 µm.
    // In a place with coordinates of some centimetres.
    const Vector3 tip(0.03, -0.02, 0.04);
    for (const double width_m : {1e-2, 1e-3, 5e-5, 5e-6, 5e-7, 2e-8}) {
        const PlainTriangle needle = triangle_of(
            {tip, tip + Vector3(-0.5 * width_m, 0, -0.05), tip + Vector3(0.5 * width_m, 0, -0.05)});
        const auto crosses = [&](const Vector3 &point_m, const Vector3 &towards) {
            const Vector3 direction = towards.normalized();
            return goes_through(needle, tip + point_m - 2e-5 * direction,
                                tip + point_m + 3e-5 * direction);
        };
        const Vector3 beyond(0, 0, 1e-8);
        EXPECT_NEAR(needle.away(tip + beyond).distance_m, 1e-8, 1e-13) << width_m;
        for (const Vector3 &towards :
             {Vector3(0, 1, 0), Vector3(0, -1, 0), Vector3(0.1, 1, 0), Vector3(1, 0.1, 0)}) {
            for (const double share : {1.0, 0.02}) {
                EXPECT_FALSE(crosses(share * beyond, towards)) << width_m;
            }
            // At the tip, within it, and as near beside it as counts.
            for (const double share : {-1.0, -1e5, 0.009}) {
                EXPECT_TRUE(crosses(share * beyond, towards)) << width_m << ' ' << share;
            }
        }
        // Beside the needle, 1 mm behind its tip, where it is 2 % as wide as at its end.
        const double half_m = 0.5 * 0.02 * width_m;
        EXPECT_FALSE(crosses({half_m + 0.2e-9, 0, -1e-3}, Vector3::UnitY()));
        EXPECT_TRUE(crosses({half_m + 0.05e-9, 0, -1e-3}, Vector3::UnitY()));
    }
}

TEST(GoesThrough, AllowsForRoundOffWhereAMotionGrazesAThinTriangle) {
    // A motion of 20 mm from 1 nm in front of a triangle to 1 nm behind, across an edge that two
    // such triangles share: whatever round-off does, one of them is met.
    std::mt19937_64 random(5);
    int beyond_both = 0;
    for (int i = 0; i < 20'000; ++i) {
        const Vector3 a = random_vector(random, 0.3);
        const Vector3 along = random_direction(random);
        const Vector3 across = along.cross(random_direction(random)).normalized();
        const Vector3 normal = along.cross(across);
        const Vector3 b = a + 0.04 * along;
        // Flat: both other corners are a few micrometres off the edge's line.
        const double thin_m = 5e-6;
        const std::array both{triangle_of({a, b, a + 0.021 * along + thin_m * across}),
                              triangle_of({b, a, a + 0.019 * along - thin_m * across})};
        const double share = 0.3 + 0.4 * static_cast<double>(random() % 1000) / 1000.0;
        const Vector3 on_edge = a + share * (b - a);
        const Vector3 direction = (along + 1e-4 * across * (i % 2 == 0 ? 1.0 : -1.0)).normalized();
        const Vector3 from = on_edge - 0.01 * direction + 1e-9 * normal;
        const Vector3 to = on_edge + 0.01 * direction - 1e-9 * normal;
        EXPECT_TRUE(goes_through(both[0], from, to) || goes_through(both[1], from, to)) << i;
        const auto is_beyond = [&](const PlainTriangle &triangle) {
            const double in_m = triangle.height_m(from);
            const double share_of_way = in_m / (in_m - triangle.height_m(to));
            return triangle.beyond_m(from + share_of_way * (to - from)) > 0.0;
        };
        beyond_both += is_beyond(both[0]) && is_beyond(both[1]) ? 1 : 0;
    }
    EXPECT_GT(beyond_both, 0); // not vacuous: without an allowance, motions would be missed
}

TEST(NearbyTriangles, FindWhatALookAtEachFinds) {
    std::mt19937_64 random(1);
    std::size_t near = 0;
    std::array<int, 2> crossed{};
    for (int mesh = 0; mesh < 60; ++mesh) {
        contact::TriangleSoup soup = testing::random_soup(random, 1 + mesh * 5, 0.04, 0.02);
        if (mesh % 3 == 0) { // needles that reach through everything, and middles in one place
            for (int i = 0; i < 50; ++i) {
                const Vector3 end = random_vector(random, 0.1);
                testing::add_triangle(soup, {end, -end, end + random_vector(random, 1e-6)});
            }
        }
        const std::vector<PlainTriangle> triangles = triangles_of(soup);
        const NearbyTriangles nearby(triangles);
        for (int i = 0; i < 100; ++i) {
            const Vector3 centre = random_vector(random, 0.06);
            const double radius_m = i % 2 == 0 ? 0.03 : 1e-3;
            const Vector3 to = centre + random_vector(random, i % 2 == 0 ? 0.06 : 2e-3);
            std::vector<std::size_t> expected;
            bool is_crossed = false;
            for (std::size_t t = 0; t < triangles.size(); ++t) {
                if (triangles[t].bounds().exteriorDistance(centre) <= radius_m) {
                    expected.push_back(t);
                }
                is_crossed = is_crossed || testing::crosses(triangles[t].corners_m, centre, to);
            }
            ASSERT_EQ(nearby.within(centre, radius_m), expected);
            ASSERT_EQ(nearby.crossed(centre, to).has_value(), is_crossed);
            near += expected.size();
            ++crossed[is_crossed ? 1 : 0];
        }
    }
    EXPECT_GT(near, 10'000U); // not vacuous
    EXPECT_GT(std::min(crossed[0], crossed[1]), 300);
}

TEST(NearbyTriangles, LetNothingThroughBetweenTriangles) {
    // Straight at the corners and edges that triangles share; outwards through their backs.
    const contact::TriangleSoup soup = testing::icosphere(3, 0.05);
    const std::vector<PlainTriangle> triangles = triangles_of(soup, FacetSides::one);
    const NearbyTriangles nearby(triangles);
    std::mt19937_64 random(3);
    for (const auto &t : soup.triangles) {
        const Vector3 a = soup.vertices_m[t[0]];
        const Vector3 b = soup.vertices_m[t[1]];
        const Vector3 on_edge = a + static_cast<double>(random() % 1000) / 999.0 * (b - a);
        EXPECT_TRUE(nearby.crossed(1.001 * on_edge, 0.999 * on_edge));
        EXPECT_TRUE(nearby.crossed(1.0001 * a, 0.9999 * a));
        EXPECT_FALSE(nearby.crossed(0.999 * on_edge, 1.001 * on_edge));
    }
}

TEST(NearbyTriangles, TakeWhatHasNoExtent) {
    EXPECT_TRUE(NearbyTriangles({}).within(Vector3::Zero(), 1.0).empty());
    EXPECT_FALSE(NearbyTriangles({}).crossed(Vector3(0, 0, 1), Vector3(0, 0, -1)));
    const std::vector<PlainTriangle> flat = triangles_of(testing::sheet(3, 0.02));
    const NearbyTriangles nearby(flat);
    EXPECT_TRUE(nearby.crossed(Vector3(0.001, 1e-7, 0), Vector3(0.001, -1e-7, 0)));
    EXPECT_TRUE(nearby.crossed(Vector3(0.001, 9, 0), Vector3(0.001, -9, 0)));
    EXPECT_FALSE(nearby.crossed(Vector3(0.021, 1, 0), Vector3(0.021, -1, 0)));
    EXPECT_FALSE(nearby.crossed(Vector3(0.001, 1, 0), Vector3(0.001, 1, 0)));
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
    const std::vector<PlainTriangle> triangles = triangles_of(testing::sheet(20, 0.02));
    const BruteForceProxy brute_force(triangles);
    struct Case {
        double from_x_m;
        double tip_x_m;
    };
    std::vector<Case> cases{{-0.0034, -0.0034}}; // is there already
    // Right above an edge, and a little before it, where the rim beyond lies as near as the plane.
    for (const double before_m : {0.0, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8}) {
        cases.push_back({0.002 + before_m, 0.001});
        cases.push_back({0.002 + before_m, 0.003});
    }
    std::mt19937_64 random(3);
    for (int i = 0; i < 30; ++i) {
        cases.push_back({random_vector(random, 0.01).x(), random_vector(random, 0.01).x()});
    }
    for (const Case &one : cases) {
        const Vector3 from(one.from_x_m, kReach_m, 0.0007);
        const Vector3 tip(one.tip_x_m, -1e-3, 0.0007);
        const BruteForceProxy::End end = brute_force.walk(from, tip, kReach_m);
        EXPECT_TRUE(end.is_lowest) << from.x();
        EXPECT_LT((end.point_m - Vector3(tip.x(), kReach_m, tip.z())).norm(), 3e-9) << from.x();
    }
}

TEST(BruteForceProxy, EndsWhereNothingNearerIsLeftAmongTrianglesWithoutOrder) {
    std::mt19937_64 random(4);
    int touching = 0;
    int wedged = 0;
    for (int mesh = 0; mesh < 60; ++mesh) {
        const contact::TriangleSoup soup = testing::random_soup(random, 200, 0.01, 0.006);
        const std::vector<PlainTriangle> triangles = triangles_of(soup);
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
    const std::vector<PlainTriangle> triangles =
        triangles_of(testing::sheet(2, 0.02), FacetSides::one);
    const BruteForceProxy brute_force(triangles);
    const Vector3 above(0.001, 2e-3, 0.002);
    const Vector3 below(0.001, -2e-3, 0.002);
    EXPECT_NEAR(brute_force.walk(above, below, kReach_m).point_m.y(), kReach_m, 1e-11);
    EXPECT_LT((brute_force.walk(below, above, kReach_m).point_m - above).norm(), 2e-9);
}

TEST(BruteForceProxy, KeepsARadiusFromAnEdge) {
    // Off the rim of a sheet the offset is round: the tip's nearest place lies straight out.
    const std::vector<PlainTriangle> triangles = triangles_of(testing::sheet(4, 0.02));
    const double radius_m = 3e-3;
    const Vector3 rim(0.02, 0.0, 0.001);
    const Vector3 out = Vector3(1, 2, 0).normalized();
    const BruteForceProxy::End end = BruteForceProxy(triangles).walk(
        rim + radius_m * Vector3::UnitY(), rim + 1e-3 * out, radius_m);
    EXPECT_TRUE(end.is_lowest);
    EXPECT_LT((end.point_m - (rim + radius_m * out)).norm(), 1e-7);
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
            const std::vector<PlainTriangle> triangles = triangles_of(soup);
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

TEST(BruteForceProxy, HopsOverRidgesLowerThanAHop) {
    // The same rib, and a tip far enough beyond it, or on this side: there a hop leads nowhere.
    for (const double height_m : {2e-9, 8e-9, 1e-7, 2.8e-7, 3.2e-7, 1e-5}) {
        for (const double tip_x_m : {0.0033, 0.0027, 0.00301}) {
            contact::TriangleSoup soup = testing::sheet(4, 0.02);
            testing::add_triangle(soup,
                                  {Vector3(0.003, height_m, -0.01), Vector3(0.003, height_m, 0.01),
                                   Vector3(0.003, -0.001, 0)});
            const std::vector<PlainTriangle> triangles = triangles_of(soup);
            const BruteForceProxy brute_force(triangles);
            const Vector3 tip(tip_x_m, -1e-3, 0.001);
            const Vector3 held_m =
                brute_force.walk(Vector3(0.002, kReach_m, 0.001), tip, kReach_m).point_m;
            const std::optional<Vector3> end_m = brute_force.hop(held_m, tip, kReach_m);
            const bool leads_on = height_m < kHop_m && tip_x_m == 0.0033;
            ASSERT_EQ(end_m.has_value(), leads_on) << height_m << ' ' << tip_x_m;
            if (leads_on) {
                EXPECT_LT((*end_m - Vector3(tip.x(), kReach_m, tip.z())).norm(), 3e-9);
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
