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
