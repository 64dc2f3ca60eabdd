// Covers engine/contact/mesh/enclosed_volume.cpp.
#include "engine/contact/mesh/enclosed_volume.h"

#include "tests/engine/contact/mesh/meshes.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

namespace springdrive::contact {
namespace {

using testing::box_soup;
using testing::edges_of;
using testing::mesh_of;

std::vector<double> volumes_m3(const std::vector<MeshTriangle> &triangles,
                               const std::vector<Vector3> &vertices_m) {
    return enclosed_volumes_m3(triangles, find_topology(triangles, edges_of(triangles)),
                               vertices_m);
}

/// Round-off of volumes of a few cubic centimetres near the origin.
constexpr double kRoundOff_m3 = 1e-17;

TEST(EnclosedVolume, IsThatOfEachBoxAndNegativeWithin) {
    const TriangleSoup outward = box_soup({0.0, 0.0, 0.0}, {0.01, 0.02, 0.03});
    const TriangleSoup inward =
        testing::turned_inside_out(box_soup({1.0, 1.0, 1.0}, {1.01, 1.01, 1.02}));
    const TriangleSoup soup = testing::joined(outward, inward);
    const std::vector<double> volumes = volumes_m3(mesh_of(soup.triangles), soup.vertices_m);
    ASSERT_EQ(volumes.size(), 2U);
    EXPECT_NEAR(volumes[0], 6e-6, kRoundOff_m3);
    EXPECT_NEAR(volumes[1], -2e-6, 1e3 * kRoundOff_m3); // 1 m off, so that much more is cancelled
}

TEST(EnclosedVolume, IsZeroForASheet) {
    TriangleSoup soup = box_soup({0.0, 0.0, 0.0}, {0.01, 0.02, 0.03});
    soup.triangles.pop_back();
    EXPECT_EQ(volumes_m3(mesh_of(soup.triangles), soup.vertices_m), std::vector<double>{0.0});
}

TEST(EnclosedVolume, IgnoresASheetInsideASolid) {
    const TriangleSoup soup = box_soup({0.0, 0.0, 0.0}, {0.01, 0.02, 0.03});
    std::vector<MeshTriangle> triangles = mesh_of(soup.triangles);
    triangles.push_back({{0, 4, 7}, 12, true}); // across two edges of the box
    const std::vector<double> volumes = volumes_m3(triangles, soup.vertices_m);
    ASSERT_EQ(volumes.size(), 1U);
    EXPECT_NEAR(volumes[0], 6e-6, kRoundOff_m3);
}

} // namespace
} // namespace springdrive::contact
