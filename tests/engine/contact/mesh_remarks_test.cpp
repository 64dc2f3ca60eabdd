// Covers engine/contact/mesh_remarks.cpp.
#include "engine/contact/mesh_remarks.h"

#include "tests/engine/contact/soups.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

namespace springdrive {
namespace {

const Vector3 kLower_m(-0.03, -0.02, -0.01);
const Vector3 kUpper_m(0.03, 0.02, 0.01);

std::vector<std::string> remarks(const TriangleSoup &soup) {
    return remarks_on(prepare_mesh(soup).report, soup.materials);
}

TEST(MeshRemarks, SaysNothingOfACleanMesh) {
    EXPECT_TRUE(remarks(testing::box_soup(kLower_m, kUpper_m)).empty());
}

TEST(MeshRemarks, NamesTheNodeWhoseTrianglesCannotBeTouched) {
    TriangleSoup soup = testing::box_soup(kLower_m, kUpper_m);
    soup.materials.push_back({"needle", 0.0});
    soup.triangles.push_back({0, 0, 1});
    soup.material_of_triangle.push_back(1);
    ASSERT_EQ(remarks(soup).size(), 1U);
    EXPECT_EQ(remarks(soup).front().substr(0, 29), "node 'needle': 1 of 13 triang");
}

TEST(MeshRemarks, SaysThatAnOpenSurfaceHasTwoSides) {
    TriangleSoup soup = testing::box_soup(kLower_m, kUpper_m);
    soup.triangles.pop_back();
    soup.material_of_triangle.pop_back();
    ASSERT_EQ(remarks(soup).size(), 1U);
    EXPECT_EQ(remarks(soup).front(), "1 of 1 surfaces are open: touched from both sides");
}

TEST(MeshRemarks, SaysThatABoxInsideOutIsTouchedFromWithin) {
    const TriangleSoup soup = testing::turned_inside_out(testing::box_soup(kLower_m, kUpper_m));
    ASSERT_EQ(remarks(soup).size(), 1U);
    EXPECT_NE(remarks(soup).front().find("face inwards"), std::string::npos);
}

} // namespace
} // namespace springdrive
