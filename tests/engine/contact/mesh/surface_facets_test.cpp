// Covers engine/contact/mesh/surface_facets.cpp.
#include "engine/contact/mesh/surface_facets.h"

#include "tests/engine/contact/mesh/meshes.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

namespace springdrive::contact {
namespace {

using testing::edges_of;
using testing::mesh_of;

std::vector<std::uint32_t> slivers(const TriangleSoup &soup, unsigned threads = 1) {
    const std::vector<MeshTriangle> triangles = mesh_of(soup.triangles);
    return slivers_to_leave_out(triangles, edges_of(triangles), soup.vertices_m, threads);
}

std::vector<FacetSource> facets(TriangleSoup soup, TouchSides sides) {
    soup.materials.front().sides = sides;
    const std::vector<MeshTriangle> triangles = mesh_of(soup.triangles);
    return make_facets(triangles, {}, find_topology(triangles, edges_of(triangles)), soup, 1);
}

/// A rectangle 1 cm long in rows of two triangles, each row `height_m` high.
TriangleSoup rows(const std::vector<double> &heights_m) {
    TriangleSoup soup;
    soup.vertices_m = {{0.0, 0.0, 0.0}, {0.01, 0.0, 0.0}};
    double y_m = 0.0;
    for (const double height_m : heights_m) {
        y_m += height_m;
        const auto first = static_cast<std::uint32_t>(soup.vertices_m.size()) - 2;
        soup.vertices_m.emplace_back(0.0, y_m, 0.0);
        soup.vertices_m.emplace_back(0.01, y_m, 0.0);
        soup.triangles.push_back({first, first + 1, first + 3});
        soup.triangles.push_back({first, first + 3, first + 2});
    }
    soup.material_of_triangle.assign(soup.triangles.size(), 0);
    soup.materials = {{"rows", 0.0}};
    return soup;
}

TEST(SurfaceFacets, LeavesOutWhatIsLowerThanTheLeastHeight) {
    EXPECT_TRUE(slivers(rows({0.01, 1.01 * kMinHeight_m, 0.01})).empty());
    // Of the two in the row, which share their diagonal, one.
    EXPECT_EQ(slivers(rows({0.01, 0.99 * kMinHeight_m, 0.01})).size(), 1U);
}

TEST(SurfaceFacets, KeepsOneOfTwoSliversSideBySide) {
    const std::vector<double> heights_m(20, 0.9 * kMinHeight_m);
    const TriangleSoup soup = rows(heights_m);
    const std::vector<std::uint32_t> left_out = slivers(soup);
    EXPECT_EQ(left_out.size(), soup.triangles.size() / 2);
    std::vector<VertexTriple> triples;
    triples.reserve(left_out.size());
    for (const std::uint32_t index : left_out) {
        triples.push_back(soup.triangles[index]);
    }
    for (const auto &[edge, counts] : testing::edge_counts(triples)) {
        EXPECT_EQ(counts[0] + counts[1], 1);
    }
}

TEST(SurfaceFacets, LeavesOutOneOfABookOfSlivers) {
    // All share the edge from 0 to 1.
    constexpr std::uint32_t kLeaves = 20'000;
    TriangleSoup soup;
    soup.vertices_m = {{0.0, 0.0, 0.0}, {0.01, 0.0, 0.0}};
    for (std::uint32_t i = 0; i < kLeaves; ++i) {
        soup.vertices_m.emplace_back(0.01 * (i + 1) / (kLeaves + 1), 0.9 * kMinHeight_m, 0.0);
        soup.triangles.push_back({0, 1, i + 2});
    }
    EXPECT_EQ(slivers(soup), std::vector<std::uint32_t>{0});
    // One without a normal leaves the gap first.
    soup.vertices_m.back().y() = 0.0;
    EXPECT_EQ(slivers(soup), std::vector<std::uint32_t>{kLeaves - 1});
}

TEST(SurfaceFacets, LeavesOutAllThatHaveNoNormal) {
    EXPECT_EQ(slivers(rows({0.01, 1e-12, 1e-12, 0.0, 0.01})).size(), 6U);
}

TEST(SurfaceFacets, LeavesTheSameOutInAnyNumberOfThreads) {
    std::vector<double> heights_m;
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> exponent(-10.0, -5.0);
    heights_m.reserve(300);
    for (int i = 0; i < 300; ++i) {
        heights_m.push_back(std::pow(10.0, exponent(random)));
    }
    EXPECT_EQ(slivers(rows(heights_m), 2), slivers(rows(heights_m), 1));
    EXPECT_EQ(slivers(rows(heights_m), 3), slivers(rows(heights_m), 1));
}

TEST(SurfaceFacets, HaveTheSidesThatTheirMaterialSpecifies) {
    const TriangleSoup box = testing::box_soup({0.0, 0.0, 0.0}, {0.01, 0.01, 0.01});
    TriangleSoup open = box;
    open.triangles.pop_back();
    const auto expect_all = [](const std::vector<FacetSource> &all, FacetSides sides) {
        for (const FacetSource &facet : all) {
            EXPECT_EQ(facet.sides, sides);
        }
    };
    expect_all(facets(box, TouchSides::automatic), FacetSides::one);
    expect_all(facets(open, TouchSides::automatic), FacetSides::two);
    expect_all(facets(box, TouchSides::two), FacetSides::two);
    expect_all(facets(open, TouchSides::one), FacetSides::one);
}

TEST(SurfaceFacets, HaveTwoSidesWhereBothWindingsWereGiven) {
    const TriangleSoup box = testing::box_soup({0.0, 0.0, 0.0}, {0.01, 0.01, 0.01});
    std::vector<MeshTriangle> triangles = mesh_of(box.triangles);
    triangles[7].has_both_windings = true;
    const std::vector<FacetSource> all =
        make_facets(triangles, {}, find_topology(triangles, edges_of(triangles)), box, 2);
    for (const FacetSource &facet : all) {
        EXPECT_EQ(facet.sides, facet.triangle == 7 ? FacetSides::two : FacetSides::one);
    }
}

TEST(SurfaceFacets, AreInOrderWithoutThoseLeftOut) {
    const TriangleSoup sphere = testing::icosphere(2, 0.03);
    const std::vector<MeshTriangle> triangles = mesh_of(sphere.triangles);
    const MeshTopology topology = find_topology(triangles, edges_of(triangles));
    const std::vector<std::uint32_t> left_out = {0, 5, 106, 107, 160, 319};
    for (const unsigned threads : {1U, 2U, 3U}) {
        const std::vector<FacetSource> all =
            make_facets(triangles, left_out, topology, sphere, threads);
        ASSERT_EQ(all.size(), triangles.size() - left_out.size());
        std::uint32_t triangle = 0;
        for (const FacetSource &facet : all) {
            while (std::ranges::count(left_out, triangle) > 0) {
                ++triangle;
            }
            ASSERT_EQ(facet.triangle, triangle);
            ASSERT_EQ(facet.corners_m, testing::corners(sphere, triangle));
            ++triangle;
        }
    }
}

} // namespace
} // namespace springdrive::contact
