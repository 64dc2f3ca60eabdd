// Covers engine/contact/mesh/mesh_warnings.cpp.
#include "engine/contact/mesh/mesh_warnings.h"

#include "engine/contact/mesh/mesh_preparation.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

namespace springdrive::contact {
namespace {

const Vector3 kBoxLower_m(-0.03, -0.02, -0.01);
const Vector3 kBoxUpper_m(0.03, 0.02, 0.01);

std::vector<std::string> warnings(const TriangleSoup &soup) {
    return warnings_about(prepare_mesh(soup).report, soup.materials);
}

TEST(MeshWarnings, SaysNothingOfACleanMesh) {
    EXPECT_TRUE(warnings(testing::box_soup(kBoxLower_m, kBoxUpper_m)).empty());
}

TEST(MeshWarnings, NamesTheNodeWhoseTrianglesCannotBeTouched) {
    TriangleSoup soup = testing::box_soup(kBoxLower_m, kBoxUpper_m);
    soup.materials.push_back({"needle", 0.0});
    soup.triangles.push_back({0, 0, 1});
    soup.material_of_triangle.push_back(1);
    ASSERT_EQ(warnings(soup).size(), 1U);
    EXPECT_EQ(warnings(soup).front().substr(0, 29), "node 'needle': 1 of 13 triang");
}

TEST(MeshWarnings, SaysThatAnOpenSurfaceHasTwoSides) {
    TriangleSoup soup = testing::box_soup(kBoxLower_m, kBoxUpper_m);
    soup.triangles.pop_back();
    soup.material_of_triangle.pop_back();
    ASSERT_EQ(warnings(soup).size(), 1U);
    EXPECT_EQ(warnings(soup).front(), "1 of 1 surfaces are open: touched from both sides");
}

TEST(MeshWarnings, SaysThatABoxInsideOutIsTouchedFromWithin) {
    const TriangleSoup soup =
        testing::turned_inside_out(testing::box_soup(kBoxLower_m, kBoxUpper_m));
    ASSERT_EQ(warnings(soup).size(), 1U);
    EXPECT_NE(warnings(soup).front().find("face inwards"), std::string::npos);
}

TEST(MeshWarnings, SaysWhatWasDoneToCloseCracks) {
    MeshReport report;
    report.open_edges_given = 12;
    report.closed_cracks = 5;
    report.split_triangles = 2;
    report.largest_move_m = 1.23e-6;
    ASSERT_EQ(warnings_about(report, {}).size(), 1U);
    EXPECT_EQ(warnings_about(report, {}).front(),
              "12 edges were open: closed by moving 5 vertices and dividing 2 triangles, with "
              "moves of up to 1.3 µm; none is open now");
    report.open_edges = 4;
    EXPECT_NE(warnings_about(report, {}).front().find("4 are open now"), std::string::npos);
}

TEST(MeshWarnings, SaysWhereFansBecameCoarse) {
    MeshReport report;
    report.graded_fans = {3, 0};
    EXPECT_TRUE(warnings_about(report, {}).empty());
    report.graded_fans.coarse = 2;
    ASSERT_EQ(warnings_about(report, {}).size(), 1U);
    EXPECT_EQ(warnings_about(report, {}).front(),
              "2 fans have many triangles at one vertex: divided anew, within 1.0 µm");
}

TEST(MeshWarnings, SaysWhatWasTurnedAndWhatHasTwoSides) {
    MeshReport report;
    report.flipped_triangles = 1;
    report.merged_triangles = 2;
    report.unorientable_components = 1;
    const std::vector<std::string> lines = warnings_about(report, {});
    ASSERT_EQ(lines.size(), 3U);
    EXPECT_EQ(lines[0], "2 triangles are given in both windings: touched from both sides");
    EXPECT_EQ(lines[1], "1 triangle was wound opposite to neighbours: turned");
    EXPECT_NE(lines[2].find("1 surface has no outside"), std::string::npos);
}

TEST(MeshWarnings, DoesNotPromiseSidesThatANodeMaySet) {
    TriangleSoup soup = testing::box_soup(kBoxLower_m, kBoxUpper_m);
    soup.triangles.pop_back();
    soup.material_of_triangle.pop_back();
    soup.materials.front().sides = TouchSides::one;
    EXPECT_EQ(warnings(soup).front(),
              "1 of 1 surfaces are open: touched from both sides, unless their nodes "
              "specify otherwise");
}

} // namespace
} // namespace springdrive::contact
