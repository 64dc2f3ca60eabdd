// Covers engine/contact/triangle_tree.cpp and engine/contact/tree_layout.cpp.
#include "engine/contact/triangle_tree.h"

#include "engine/contact/preparation/mesh_preparation.h"
#include "tests/engine/contact/soups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace springdrive {
namespace {

using testing::icosphere;
using testing::random_direction;
using testing::random_vector;

/// The first crossing, by asking every facet.
std::optional<SurfaceHit> first_of_all(const TriangleTree &tree, const Vector3 &from,
                                       const Vector3 &to) {
    std::optional<SurfaceHit> first;
    for (const Facet &facet : tree.facets()) {
        const std::optional<double> fraction = facet.stop(from, to);
        if (fraction && (!first || *fraction < first->fraction)) {
            first = SurfaceHit{*fraction, &facet};
        }
    }
    return first;
}

/// Random motions of all lengths, some along the axes. Returns how many hit.
int compare_with_brute_force(const TriangleTree &tree, int motions, std::mt19937_64 &random) {
    std::uniform_real_distribution<double> exponent(-8.0, 0.0);
    int hits = 0;
    for (int i = 0; i < motions; ++i) {
        const Vector3 from = random_vector(random, 0.12);
        Vector3 step =
            std::pow(10.0, i % 2 == 0 ? 0.0 : exponent(random)) * random_vector(random, 0.2);
        if (i % 5 == 0) {
            step[i % 3] = 0.0;
            step[(i / 5) % 3] = 0.0;
        }
        const std::optional<SurfaceHit> expected = first_of_all(tree, from, from + step);
        const std::optional<SurfaceHit> found = tree.first_hit(from, from + step);
        EXPECT_EQ(found.has_value(), expected.has_value());
        if (found && expected) {
            ++hits;
            EXPECT_EQ(found->fraction, expected->fraction);
        }
        if (::testing::Test::HasFailure()) {
            return hits;
        }
    }
    return hits;
}

TriangleTree tree_of(const TriangleSoup &soup) { return TriangleTree(prepare_mesh(soup).facets); }

TEST(TriangleTree, OfNothingIsNeverHit) {
    EXPECT_FALSE(TriangleTree().first_hit(-Vector3::Ones(), Vector3::Ones()));
    EXPECT_FALSE(tree_of({}).first_hit(-Vector3::Ones(), Vector3::Ones()));
}

TEST(TriangleTree, AgreesWithBruteForceOnRandomSoups) {
    std::mt19937_64 random(1);
    for (const int triangles : {1, 2, 5, 30, 300, 2000}) {
        const TriangleSoup soup =
            testing::random_soup(random, triangles, 0.1, triangles < 100 ? 0.1 : 0.02);
        const int hits = compare_with_brute_force(tree_of(soup), 3000, random);
        EXPECT_GT(hits, triangles < 5 ? 0 : 30);
    }
}

TEST(TriangleTree, AgreesWithBruteForceOnClosedSurfaces) {
    std::mt19937_64 random(2);
    EXPECT_GT(compare_with_brute_force(tree_of(testing::bumpy_sphere(3, 0.08)), 10000, random),
              500);
}

TEST(TriangleTree, HoldsEveryFacetOnceWhateverTheirArrangement) {
    std::mt19937_64 random(3);
    TriangleSoup soup;
    // All centres equal: no plane can divide them. And sizes that grow without end, which is what
    // makes a tree deep.
    for (int i = 0; i < 200; ++i) {
        const Vector3 arm = 0.05 * random_direction(random);
        const Vector3 other = 0.05 * random_direction(random);
        testing::add_triangle(soup, {arm, other, -arm - other});
    }
    for (int i = 0; i < 200; ++i) {
        const double size = 2e-4 * std::pow(1.04, i);
        testing::add_triangle(soup,
                              {Vector3(size, 0, 0), Vector3(0, size, 0), Vector3(0, 0, size)});
    }
    const TriangleTree tree = tree_of(soup);
    std::vector<std::uint32_t> triangles;
    for (const Facet &facet : tree.facets()) {
        triangles.push_back(facet.triangle());
    }
    std::ranges::sort(triangles);
    std::vector<std::uint32_t> expected(400);
    std::iota(expected.begin(), expected.end(), 0U);
    EXPECT_EQ(triangles, expected);
    EXPECT_GT(compare_with_brute_force(tree, 3000, random), 100);
}

TEST(TriangleTree, LetsNoMotionThroughAnEdgeOrAVertexOfASphere) {
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    constexpr double kRadius_m = 0.03;
    const Vector3 centre(0.013, -0.047, 0.021);
    TriangleSoup soup = icosphere(3, kRadius_m);
    for (Vector3 &vertex : soup.vertices_m) {
        vertex += centre;
    }
    const TriangleTree tree = tree_of(soup);
    for (int i = 0; i < 100000; ++i) {
        const auto triangle = soup.triangles[random() % soup.triangles.size()];
        const Vector3 &a = soup.vertices_m[triangle[0]];
        const Vector3 &b = soup.vertices_m[triangle[1]];
        const double along = i % 3 == 0 ? 0.0 : unit(random); // a third at vertices
        const Vector3 aim = a + along * (b - a);
        const Vector3 inside = centre + random_vector(random, 0.4 * kRadius_m);
        const Vector3 outside = inside + (1.1 + 3.0 * unit(random)) * (aim - inside);
        ASSERT_TRUE(tree.first_hit(outside, inside)) << i;
    }
}

TEST(TriangleTree, LetsNoMotionThroughNarrowCracksAndTJunctions) {
    std::mt19937_64 random(5);
    // The left half is one pair of triangles; the right half is shifted by less than the rim and
    // its vertices meet the middle of the left one's edge.
    constexpr double kCrack_m = 0.9 * kRim_m;
    TriangleSoup soup;
    const auto add_rectangle = [&](double x0, double y0, double x1, double y1) {
        testing::add_triangle(soup, {Vector3(x0, y0, 0), Vector3(x1, y0, 0), Vector3(x1, y1, 0)});
        testing::add_triangle(soup, {Vector3(x0, y0, 0), Vector3(x1, y1, 0), Vector3(x0, y1, 0)});
    };
    add_rectangle(-0.05, -0.05, 0.0, 0.05);
    for (int i = 0; i < 7; ++i) {
        const double cell = 0.1 / 7;
        add_rectangle(kCrack_m, -0.05 + i * cell, 0.05, -0.05 + (i + 1) * cell);
    }
    const TriangleTree tree = tree_of(soup);
    std::uniform_real_distribution<double> y(-0.05, 0.05);
    std::uniform_real_distribution<double> x(0.0, kCrack_m);
    for (int i = 0; i < 20000; ++i) {
        const Vector3 aim(x(random), y(random), 0.0);
        const Vector3 arm = random_vector(random, 0.02) + 0.03 * Vector3::UnitZ();
        ASSERT_TRUE(tree.first_hit(aim + arm, aim - 0.5 * arm)) << aim.transpose();
    }
}

TEST(TriangleTree, FindsNothingForMotionsWithoutLengthOrSense) {
    const TriangleTree tree = tree_of(icosphere(2, 0.03));
    const Vector3 on_vertex = 0.03 * Vector3::UnitX();
    EXPECT_FALSE(tree.first_hit(on_vertex, on_vertex));
    EXPECT_FALSE(tree.first_hit(Vector3::Constant(NAN), Vector3::Zero()));
    EXPECT_FALSE(tree.first_hit(Vector3::UnitX(), Vector3::Constant(NAN)));
}

} // namespace
} // namespace springdrive
