// Covers engine/lab/rig/crossing_finder.cpp.
#include "engine/lab/rig/crossing_finder.h"

#include "tests/engine/contact/proxy/optimality.h"

#include <gtest/gtest.h>

namespace springdrive::rig {
namespace {

using testing::random_vector;

std::vector<PlainTriangle> triangles_of(const contact::TriangleSoup &soup,
                                        contact::FacetSides sides) {
    std::vector<contact::FacetSource> facets;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        facets.push_back({testing::corners(soup, i), sides, static_cast<unsigned>(i)});
    }
    return plain_triangles(facets);
}

TEST(CrossingFinder, FindsWhatBruteForceFinds) {
    std::mt19937_64 random(1);
    int crossed = 0;
    int clear = 0;
    for (int mesh = 0; mesh < 40; ++mesh) {
        const contact::TriangleSoup soup = testing::random_soup(random, 5 + mesh * 5, 0.04, 0.02);
        const std::vector<PlainTriangle> triangles = triangles_of(soup, contact::FacetSides::two);
        const CrossingFinder finder(triangles);
        for (int i = 0; i < 100; ++i) {
            const Vector3 from = random_vector(random, 0.06);
            const double length_m = i % 2 == 0 ? 0.06 : 2e-3;
            const Vector3 to = from + random_vector(random, length_m);
            bool expected = false;
            for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
                expected = expected || testing::crosses(testing::corners(soup, t), from, to);
            }
            ASSERT_EQ(finder.crossed(from, to).has_value(), expected);
            ++(expected ? crossed : clear);
        }
    }
    EXPECT_GT(crossed, 300);
    EXPECT_GT(clear, 300);
}

TEST(CrossingFinder, FindsEveryWayIntoAClosedSurfaceAndNoneOut) {
    const contact::TriangleSoup soup = testing::bumpy_sphere(4, 0.05);
    const std::vector<PlainTriangle> triangles = triangles_of(soup, contact::FacetSides::one);
    const CrossingFinder finder(triangles);
    std::mt19937_64 random(2);
    for (int i = 0; i < 500; ++i) {
        const Vector3 outside = 0.08 * testing::random_direction(random);
        const Vector3 inside = random_vector(random, 0.01);
        EXPECT_TRUE(finder.crossed(outside, inside));
        EXPECT_FALSE(finder.crossed(inside, outside)); // star-shaped: never in again
    }
}

TEST(CrossingFinder, LetsNothingThroughBetweenTriangles) {
    // Straight at the corners and edges that triangles share.
    const contact::TriangleSoup soup = testing::icosphere(3, 0.05);
    const std::vector<PlainTriangle> triangles = triangles_of(soup, contact::FacetSides::one);
    const CrossingFinder finder(triangles);
    std::mt19937_64 random(3);
    for (const auto &t : soup.triangles) {
        const Vector3 a = soup.vertices_m[t[0]];
        const Vector3 b = soup.vertices_m[t[1]];
        const double share = static_cast<double>(random() % 1000) / 999.0;
        const Vector3 on_edge = a + share * (b - a);
        EXPECT_TRUE(finder.crossed(1.001 * on_edge, 0.999 * on_edge));
        EXPECT_TRUE(finder.crossed(1.0001 * a, 0.9999 * a));
    }
}

TEST(GoesThrough, TellsSidesAndRims) {
    const testing::Corners corners{Vector3(0, 0, 0), Vector3(0, 0, 0.01), Vector3(0.01, 0, 0)};
    const PlainTriangle one = plain_triangles({{corners, contact::FacetSides::one, 0}})[0];
    const PlainTriangle two = plain_triangles({{corners, contact::FacetSides::two, 0}})[0];
    const auto column = [](double x, double y) { return Vector3(x, y, 0.002); };
    const double h = 1e-6;
    EXPECT_TRUE(goes_through(one, column(2e-3, h), column(2e-3, -h)));
    EXPECT_FALSE(goes_through(one, column(2e-3, -h), column(2e-3, h)));
    EXPECT_TRUE(goes_through(two, column(2e-3, -h), column(2e-3, h)));
    EXPECT_FALSE(goes_through(two, column(2e-3, h), column(2e-3, 0.1 * h)));
    EXPECT_FALSE(goes_through(two, column(2e-3, -h), column(2e-3, -0.1 * h)));
    // The rim along z: 0.1 nm beyond it still counts, the 10 nm that the proxy keeps do not.
    EXPECT_TRUE(goes_through(one, column(-0.9e-10, h), column(-0.9e-10, -h)));
    EXPECT_FALSE(goes_through(one, column(-1.1e-10, h), column(-1.1e-10, -h)));
}

/// A needle along z with its tip at the origin, in a place with coordinates of some centimetres.
const Vector3 kTip(0.03, -0.02, 0.04);

PlainTriangle needle(double width_m) {
    const testing::Corners corners{kTip, Vector3(kTip + Vector3(-0.5 * width_m, 0, -0.05)),
                                   Vector3(kTip + Vector3(0.5 * width_m, 0, -0.05))};
    return plain_triangles({{corners, contact::FacetSides::two, 0}})[0];
}

/// A motion through the needle's plane, at `point_m` seen from its tip.
bool goes_through_at(const PlainTriangle &triangle, const Vector3 &point_m,
                     const Vector3 &direction = Vector3::UnitY()) {
    const Vector3 at = kTip + point_m;
    return goes_through(triangle, at - 2e-5 * direction, at + 3e-5 * direction);
}

TEST(GoesThrough, IsNotMistakenBesideTheTipOfANeedle) {
    // Beyond the tip both long edges are as near as the needle is thin: 5 pm at 10 nm for 50 µm.
    for (const double width_m : {1e-2, 1e-3, 5e-5, 5e-6, 5e-7, 2e-8}) {
        const PlainTriangle triangle = needle(width_m);
        const Vector3 beyond(0, 0, 1e-8);
        EXPECT_GT(triangle.beyond_m(kTip + beyond), 0.9e-8) << width_m;
        EXPECT_NEAR(triangle.away(kTip + beyond).distance_m, 1e-8, 1e-13) << width_m;
        for (const Vector3 &direction :
             {Vector3(0, 1, 0), Vector3(0, -1, 0), Vector3(0.1, 1, 0), Vector3(1, 0.1, 0)}) {
            EXPECT_FALSE(goes_through_at(triangle, beyond, direction.normalized())) << width_m;
            EXPECT_FALSE(goes_through_at(triangle, 0.02 * beyond, direction.normalized()));
            // The other side: at the tip, within it, and as near beside it as counts.
            EXPECT_TRUE(goes_through_at(triangle, -beyond, direction.normalized())) << width_m;
            EXPECT_TRUE(goes_through_at(triangle, -1e5 * beyond, direction.normalized()));
            EXPECT_TRUE(goes_through_at(triangle, 0.009 * beyond, direction.normalized()));
        }
        // Beside the needle, 1 mm behind its tip, where it is 2 % as wide as at its end.
        const double half_m = 0.5 * 0.02 * width_m;
        EXPECT_FALSE(goes_through_at(triangle, {half_m + 0.2e-9, 0, -1e-3}));
        EXPECT_TRUE(goes_through_at(triangle, {half_m + 0.05e-9, 0, -1e-3}));
        EXPECT_TRUE(goes_through_at(triangle, {0.9 * half_m, 0, -1e-3}));
    }
}

TEST(GoesThrough, IsNotMistakenBesideAnEndOfAFlatTriangle) {
    // All three edges are almost parallel.
    for (const double height_m : {1e-3, 1e-5, 1e-6, 1e-7}) {
        for (const double foot : {0.1, 0.5, 0.97}) {
            const testing::Corners corners{kTip, Vector3(kTip + Vector3(height_m, 0, -0.05 * foot)),
                                           Vector3(kTip + Vector3(0, 0, -0.05))};
            const PlainTriangle triangle =
                plain_triangles({{corners, contact::FacetSides::two, 0}})[0];
            for (const Vector3 &beyond : {Vector3(0, 0, 1e-8), Vector3(0, 0, -0.05 - 1e-8)}) {
                EXPECT_NEAR(triangle.away(kTip + beyond).distance_m, 1e-8, 1e-12) << height_m;
                EXPECT_FALSE(goes_through_at(triangle, beyond)) << height_m;
                const double inwards = beyond.z() > 0 ? -1.0 : 1.0;
                EXPECT_TRUE(goes_through_at(triangle, beyond + Vector3(0, 0, 2e-8 * inwards)));
            }
        }
    }
}

TEST(PlainTriangle, IsAtLeastHalfAsFarBeyondAsItsDistance) {
    std::mt19937_64 random(6);
    for (int i = 0; i < 30'000; ++i) {
        testing::Corners corners{random_vector(random, 0.03), random_vector(random, 0.03),
                                 random_vector(random, 0.03)};
        if (i % 3 > 0) { // a needle, or flat
            const Vector3 side = corners[1] - corners[0];
            corners[2] = corners[i % 3 == 1 ? 0 : 1] + (i % 3 == 1 ? 0.0 : 0.4) * side +
                         random_vector(random, 1e-5);
        }
        const PlainTriangle triangle = plain_triangles({{corners, contact::FacetSides::two, 0}})[0];
        const Vector3 at = corners[random() % 3] + random_vector(random, i % 2 == 0 ? 1e-7 : 0.05);
        const Vector3 point = at - triangle.height_m(at) * triangle.normal;
        const double distance_m = testing::distance_to_triangle(corners, point);
        // The plane itself is known to this, as its normal is the product of parallel edges.
        const double round_off_m = 11.0 * 1.1e-16 * 0.1 / triangle.sine() + 1e-15;
        EXPECT_LE(triangle.beyond_m(point), distance_m + round_off_m);
        EXPECT_GE(std::max(triangle.beyond_m(point), 0.0), 0.5 * distance_m - round_off_m);
    }
}

TEST(GoesThrough, AllowsForRoundOffWhereAMotionGrazesAThinTriangle) {
    // A motion of 20 mm from 1 nm in front of a triangle to 1 nm behind, across an edge that two
    // such triangles share: whatever round-off does, one of them is met.
    std::mt19937_64 random(5);
    int beyond_both = 0;
    for (int i = 0; i < 20'000; ++i) {
        const Vector3 a = random_vector(random, 0.3);
        const Vector3 along = testing::random_direction(random);
        const Vector3 across = along.cross(testing::random_direction(random)).normalized();
        const Vector3 normal = along.cross(across);
        const Vector3 b = a + 0.04 * along;
        // Flat: both other corners are a few micrometres off the edge's line.
        const double thin_m = 5e-6;
        const testing::Corners left{a, b, Vector3(a + 0.021 * along + thin_m * across)};
        const testing::Corners right{b, a, Vector3(a + 0.019 * along - thin_m * across)};
        const std::vector<PlainTriangle> both = plain_triangles(
            {{left, contact::FacetSides::two, 0}, {right, contact::FacetSides::two, 1}});
        const double share = 0.3 + 0.4 * static_cast<double>(random() % 1000) / 1000.0;
        const Vector3 on_edge = a + share * (b - a);
        const Vector3 direction = (along + 1e-4 * across * (i % 2 == 0 ? 1.0 : -1.0)).normalized();
        const Vector3 from = on_edge - 0.01 * direction + 1e-9 * normal;
        const Vector3 to = on_edge + 0.01 * direction - 1e-9 * normal;
        EXPECT_TRUE(goes_through(both[0], from, to) || goes_through(both[1], from, to)) << i;
        const auto crossing_beyond_m = [&](const PlainTriangle &triangle) {
            const double in_m = triangle.height_m(from);
            const double share_of_way = in_m / (in_m - triangle.height_m(to));
            return triangle.beyond_m(from + share_of_way * (to - from));
        };
        beyond_both += crossing_beyond_m(both[0]) > 0 && crossing_beyond_m(both[1]) > 0 ? 1 : 0;
    }
    EXPECT_GT(beyond_both, 0); // not vacuous: without an allowance, motions would be missed
}

TEST(CrossingFinder, TakesWhatHasNoExtent) {
    const CrossingFinder none({});
    EXPECT_FALSE(none.crossed(Vector3(0, 0, 1), Vector3(0, 0, -1)));
    const std::vector<PlainTriangle> flat =
        triangles_of(testing::sheet(3, 0.02), contact::FacetSides::two);
    const CrossingFinder finder(flat);
    EXPECT_TRUE(finder.crossed(Vector3(0.001, 1e-7, 0), Vector3(0.001, -1e-7, 0)));
    EXPECT_TRUE(finder.crossed(Vector3(0.001, 9, 0), Vector3(0.001, -9, 0)));
    EXPECT_FALSE(finder.crossed(Vector3(0.021, 1, 0), Vector3(0.021, -1, 0)));
    EXPECT_FALSE(finder.crossed(Vector3(0.001, 1, 0), Vector3(0.001, 1, 0)));
}

} // namespace
} // namespace springdrive::rig
