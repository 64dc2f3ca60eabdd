// Covers engine/contact/mesh_preparation.cpp.
#include "engine/contact/mesh_preparation.h"

#include "tests/engine/contact/soups.h"
#include "tests/support/devices.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace springdrive {
namespace {

using testing::add_triangle;
using testing::box_soup;
using testing::Corners;
using testing::corners;
using testing::joined;

const Vector3 kLower_m(-0.01, -0.01, -0.01);
const Vector3 kUpper_m(0.01, 0.02, 0.03);

/// The same triangles, each with vertices of its own.
TriangleSoup unshared(const TriangleSoup &soup) {
    TriangleSoup result;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        add_triangle(result, corners(soup, i));
    }
    return result;
}

bool are_all(const PreparedMesh &mesh, FacetSides sides) {
    return std::ranges::all_of(mesh.facets,
                               [sides](const FacetSource &facet) { return facet.sides == sides; });
}

TEST(MeshPreparation, OfAnEmptySoupIsEmpty) {
    const PreparedMesh mesh = prepare_mesh({});
    EXPECT_TRUE(mesh.facets.empty());
    EXPECT_EQ(mesh.report.components, 0U);
}

TEST(MeshPreparation, WeldsABoxOfLooseTrianglesShut) {
    const PreparedMesh mesh = prepare_mesh(unshared(box_soup(kLower_m, kUpper_m)));
    EXPECT_EQ(mesh.report.triangles_given, 12U);
    EXPECT_EQ(mesh.report.triangles_kept, 12U);
    EXPECT_EQ(mesh.report.welded_vertices, 36U - 8U);
    EXPECT_EQ(mesh.report.open_edges, 0U);
    EXPECT_EQ(mesh.report.components, 1U);
    EXPECT_EQ(mesh.report.closed_components, 1U);
    EXPECT_EQ(mesh.report.inward_components, 0U);
    EXPECT_TRUE(are_all(mesh, FacetSides::one));
}

TEST(MeshPreparation, ReportsABoxThatFacesInwards) {
    const PreparedMesh mesh =
        prepare_mesh(testing::turned_inside_out(box_soup(kLower_m, kUpper_m)));
    EXPECT_EQ(mesh.report.closed_components, 1U);
    EXPECT_EQ(mesh.report.inward_components, 1U);
}

TEST(MeshPreparation, MakesASheetTouchableFromBothSides) {
    const PreparedMesh mesh = prepare_mesh(testing::sheet(3, 0.05));
    EXPECT_EQ(mesh.report.closed_components, 0U);
    EXPECT_EQ(mesh.report.open_edges, 12U);
    EXPECT_TRUE(are_all(mesh, FacetSides::two));
}

TEST(MeshPreparation, TreatsEachComponentOnItsOwn) {
    const TriangleSoup soup = joined(box_soup(kLower_m, kUpper_m), testing::sheet(1, 0.05));
    const PreparedMesh mesh = prepare_mesh(soup);
    EXPECT_EQ(mesh.report.components, 2U);
    EXPECT_EQ(mesh.report.closed_components, 1U);
    for (const FacetSource &facet : mesh.facets) {
        EXPECT_EQ(facet.sides, facet.triangle < 12 ? FacetSides::one : FacetSides::two);
    }
}

TEST(MeshPreparation, DropsRepeatedTrianglesAndStaysClosed) {
    TriangleSoup soup = box_soup(kLower_m, kUpper_m);
    const auto &[a, b, c] = soup.triangles[5];
    add_triangle(soup, {soup.vertices_m[b], soup.vertices_m[c], soup.vertices_m[a]});
    const PreparedMesh mesh = prepare_mesh(soup);
    EXPECT_EQ(mesh.report.duplicate_triangles, 1U);
    EXPECT_EQ(mesh.report.triangles_kept, 12U);
    EXPECT_EQ(mesh.report.closed_components, 1U);
}

TEST(MeshPreparation, KeepsTheOtherSideOfATriangle) {
    TriangleSoup soup;
    add_triangle(soup, {Vector3(0, 0, 0), Vector3(0.01, 0, 0), Vector3(0, 0.01, 0)});
    add_triangle(soup, {Vector3(0, 0, 0), Vector3(0, 0.01, 0), Vector3(0.01, 0, 0)});
    const PreparedMesh mesh = prepare_mesh(soup);
    EXPECT_EQ(mesh.report.triangles_kept, 2U);
    EXPECT_EQ(mesh.report.closed_components, 1U); // a volume of no thickness
}

TEST(MeshPreparation, DropsDegenerateTrianglesAndStaysClosed) {
    TriangleSoup soup = box_soup(kLower_m, kUpper_m);
    // A sliver between two halves of a triangle: corner, corner, and the middle of their edge.
    const auto [a, b, c] = soup.triangles[0];
    const Vector3 middle = 0.5 * (soup.vertices_m[a] + soup.vertices_m[b]);
    const Corners first = {middle, soup.vertices_m[b], soup.vertices_m[c]};
    soup.triangles[0] = {a, static_cast<std::uint32_t>(soup.vertices_m.size()), c};
    soup.vertices_m.push_back(middle);
    add_triangle(soup, first);
    add_triangle(soup, {soup.vertices_m[a], soup.vertices_m[b], middle});
    // And triangles that collapse to a segment and to a point.
    add_triangle(soup, {middle, middle, soup.vertices_m[c]});
    add_triangle(soup, {middle, middle, middle});
    const PreparedMesh mesh = prepare_mesh(soup);
    EXPECT_EQ(mesh.report.degenerate_triangles, 3U);
    EXPECT_EQ(mesh.report.triangles_kept, 13U);
    EXPECT_EQ(mesh.report.closed_components, 1U);
    EXPECT_TRUE(are_all(mesh, FacetSides::one));
}

TEST(MeshPreparation, DropsTrianglesThatAreNotFinite) {
    TriangleSoup soup = box_soup(kLower_m, kUpper_m);
    add_triangle(soup,
                 {Vector3(0, 0, std::numeric_limits<double>::quiet_NaN()), kLower_m, kUpper_m});
    const PreparedMesh mesh = prepare_mesh(soup);
    EXPECT_EQ(mesh.report.degenerate_triangles, 1U);
    EXPECT_EQ(mesh.report.triangles_kept, 12U);
}

TEST(MeshPreparation, RemembersWhichTriangleAFacetCameFrom) {
    std::mt19937_64 random(1);
    TriangleSoup soup = testing::icosphere(2, 0.03);
    std::ranges::shuffle(soup.triangles, random);
    for (const FacetSource &facet : prepare_mesh(soup).facets) {
        for (const Vector3 &corner : corners(soup, facet.triangle)) {
            ASSERT_NE(std::ranges::find(facet.corners_m, corner), facet.corners_m.end());
        }
    }
}

TEST(MeshPreparation, RefusesIndicesOutOfRange) {
    TriangleSoup soup = box_soup(kLower_m, kUpper_m);
    soup.triangles[3][1] = 8;
    EXPECT_THROW(static_cast<void>(prepare_mesh(soup)), std::invalid_argument);
}

TEST(MeshPreparation, RefusesATriangleWithoutMaterial) {
    TriangleSoup soup = box_soup(kLower_m, kUpper_m);
    soup.material_of_triangle[3] = 1;
    EXPECT_THROW(static_cast<void>(prepare_mesh(soup)), std::invalid_argument);
    soup.material_of_triangle.pop_back();
    EXPECT_THROW(static_cast<void>(prepare_mesh(soup)), std::invalid_argument);
}

} // namespace
} // namespace springdrive
